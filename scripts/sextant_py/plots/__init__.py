"""Pictures of traces and recordings: panels, spectra, loci; as PNG and as interactive HTML."""
