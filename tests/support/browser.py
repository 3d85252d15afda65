"""The browser that is installed, for tests that look at pages."""

import os
import shutil

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# WebGL without a graphics card; a container's root may not have a sandbox.
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
PATIENCE = 120_000  # ms; drawing without a graphics card on a busy machine


def browser_path() -> str:
    """Its path; a test fails without one."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None) or os.environ.get("CAMRING_BROWSER")
    assert found, (
        f"no browser to look at pages with: none of {', '.join(BROWSERS)} is installed. On Debian and Ubuntu: "
        "apt-get install chromium. Or give the path of a Chromium or Chrome in CAMRING_BROWSER"
    )
    return found
