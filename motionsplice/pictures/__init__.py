"""Contact sheets, animations and charts."""
