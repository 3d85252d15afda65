"""Wachter 2021 repeated: its areas, fits, tables and figures."""
