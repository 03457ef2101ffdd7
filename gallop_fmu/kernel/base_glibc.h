/* Binds functions of glibc, whose symbols got new versions in 2.29, to their first ones: the
 * library then loads with glibc 2.17 as well.  The new versions compute the same; they only leave
 * errno alone.  It needs a library that is linked with libm, which other builds of these sources
 * may not be; ours defines GALLOP_OLD_GLIBC. */
#ifndef GALLOP_BASE_GLIBC_H
#define GALLOP_BASE_GLIBC_H

#include <math.h>

#if defined(GALLOP_OLD_GLIBC) && defined(__GLIBC__) && defined(__x86_64__) && !defined(__ILP32__)
__asm__(".symver exp2,exp2@GLIBC_2.2.5");
__asm__(".symver log,log@GLIBC_2.2.5");
__asm__(".symver log2,log2@GLIBC_2.2.5");
__asm__(".symver pow,pow@GLIBC_2.2.5");
#endif

#endif
