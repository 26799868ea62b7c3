//! Raw rows into metrics, verdicts and tables
