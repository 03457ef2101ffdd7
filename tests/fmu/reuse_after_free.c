/* Loaded before all else: operator delete keeps the block and makes it look like the control block
   of a shared pointer with one owner left and no functions, so that a program that uses freed
   memory ends with a segmentation fault. */
#include <stddef.h>

void _ZdlPvm(void *block, size_t size)
{
    if (block && size >= 16) {
        ((void **)block)[0] = NULL;
        ((int *)block)[2] = ((int *)block)[3] = 1;
    }
}
