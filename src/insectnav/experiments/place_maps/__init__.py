"""Maps of places from folders of pictures, films, recordings of robots and arrays, and places found again in them."""
