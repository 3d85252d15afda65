"""The error with which points are reconstructed, predicted over a surface: bounds, contours, averages."""
