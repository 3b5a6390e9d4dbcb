"""insectnav: insect visual navigation, from the sky above an ant to the circuit that steers a bee home."""

__version__ = "0.1.0"
