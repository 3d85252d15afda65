"""What is proven of layouts."""
