/* The direct solver of a chain, and of the junctions, for a complex blend of its matrices: two of a
 * collocation method's stages have one complex conjugate pair of eigenvalues between them. */
#define PARTS 2
#define ENTRY(name) solver_complex_##name
#include "solver_block.h"
#include "solver_junctions.h"
