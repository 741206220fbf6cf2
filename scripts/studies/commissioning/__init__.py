"""What commissioning finds, beside what is true."""
