"""Recordings: groups of signals over one clock, in the file formats HDF5, MCAP, MDF4, CSV and Parquet."""
