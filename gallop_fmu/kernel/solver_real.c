/* The direct solver of a chain, and of the junctions, for a real tangent. */
#define PARTS 1
#define ENTRY(name) solver_real_##name
#include "solver_block.h"
#include "solver_junctions.h"
