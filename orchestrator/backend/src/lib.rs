//! Runs a cell: namespaces, processes, certificate, rows
