"""What tests share: scenes, made-up requests, an independent computation, files."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
PUBLISHED_AREAS = Path(__file__).parent / "published_areas.csv"
