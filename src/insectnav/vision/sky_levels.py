"""How the levels of elevation of a picture are numbered."""

LEFT_OUT = 255  # elevation level of a pixel that does not count
