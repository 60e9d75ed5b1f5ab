"""The page at /view, where an animator looks at splices. The page is an ordinary client of the service."""
