"""Exact areas against rays: an estimate that shares no code with them."""
