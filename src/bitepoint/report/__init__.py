"""Reports: figures for people."""
