"""The studies: evidence about the drive, by the programs of sextant_py, which import none of them."""
