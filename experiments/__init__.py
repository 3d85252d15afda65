"""What a person runs: the command line, tables, figures, studies, benchmarks."""
