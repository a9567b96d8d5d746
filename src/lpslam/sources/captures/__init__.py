"""Recordings of phones and data sets, one module a layout."""
