"""From a problem to a layout: candidates, exact scores, polish, and what they are compared with."""
