"""The paper that the drive follows, number by number: docs/paper."""
