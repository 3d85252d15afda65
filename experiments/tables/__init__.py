"""Tables of layouts, sites and faults, as a person reads them and as CSV."""
