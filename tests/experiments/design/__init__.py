"""The designer: its page in a real browser, its server, and what is behind them."""
