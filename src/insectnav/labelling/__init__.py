"""Ground truth by hand: strokes of sky and ground on a picture, grown to a mask, on a local web page or without one."""
