"""The cell populations of the circuit, in anatomical order, and where each keeps its activity."""

# Number of cells; Stone et al. 2017, Fig. 4 and Methods, doi 10.1016/j.cub.2017.08.052.
N_CELLS = {
    "tl": 16,  # tangential cells of the lower central body: the compass input
    "cl1": 16,  # columnar cells of the lower central body: the inverted compass
    "tb1": 8,  # tangential cells of the protocerebral bridge: the ring attractor that holds the heading
    "tn2": 2,  # noduli tangential cells that respond to forward flow, right and left
    "cpu4": 16,  # columnar cells: read-out of the home-vector memory
    "pontine": 16,  # pontine cells of the upper central body: balance the two memories
    "cpu1": 16,  # columnar cells that compare heading and memory: steering
    "tn1": 2,  # noduli tangential cells that respond to backward flow
    "memory": 16,  # charge of each CPU4 cell
    "motor": 1,  # turn of the body [rad], positive to the right
}

POPULATIONS = ("tl", "cl1", "tb1", "tn1", "tn2", "memory", "cpu4", "pontine", "cpu1", "motor")  # as in the circuit

ROW = {}  # first row of each population in the array of activities
_next_row = 0
for _name, _n_cells in N_CELLS.items():
    ROW[_name] = _next_row
    _next_row += _n_cells
N_ROWS = _next_row
N_NOISY = N_ROWS - N_CELLS["memory"] - N_CELLS["motor"]  # the first rows: cells with a firing rate
POPULATIONS_WITH_RATE = tuple(name for name in N_CELLS if ROW[name] < N_NOISY)


def rows(population: str) -> slice:
    """Rows of a population in the array of activities."""
    return slice(ROW[population], ROW[population] + N_CELLS[population])
