/* SPDX-License-Identifier: GPL-2.0-or-later
   Vectors of four doubles, and how kernels are compiled for several instruction sets.  Words: docs/glossary.md. */

#ifndef DISC_KERNELS_SIMD_H
#define DISC_KERNELS_SIMD_H

/* Compiled for several instruction sets (unless DISC_PLAIN is defined); the widest that the machine has is taken when
   the library is loaded. */
#if !defined(DISC_PLAIN) && defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define DISC_WIDEST __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define DISC_WIDEST
#endif
#define DISC_INLINE inline __attribute__((always_inline))

namespace disc
{

typedef double Vec4 __attribute__((vector_size(32), may_alias));
#if defined(__clang__)
#define DISC_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
typedef long Index4 __attribute__((vector_size(32)));
#define DISC_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, Index4{i, j, k, l})
#endif

/* Exchange the rows and columns of a 4 x 4 matrix. */
DISC_INLINE void transpose(Vec4 &a, Vec4 &b, Vec4 &c, Vec4 &d)
{
  const Vec4 ab0 = DISC_SHUFFLE(a, b, 0, 4, 2, 6), ab1 = DISC_SHUFFLE(a, b, 1, 5, 3, 7);
  const Vec4 cd0 = DISC_SHUFFLE(c, d, 0, 4, 2, 6), cd1 = DISC_SHUFFLE(c, d, 1, 5, 3, 7);
  a = DISC_SHUFFLE(ab0, cd0, 0, 1, 4, 5);
  b = DISC_SHUFFLE(ab1, cd1, 0, 1, 4, 5);
  c = DISC_SHUFFLE(ab0, cd0, 2, 3, 6, 7);
  d = DISC_SHUFFLE(ab1, cd1, 2, 3, 6, 7);
}

DISC_INLINE Vec4 &vec4(double *p) { return *reinterpret_cast<Vec4 *>(p); }
DISC_INLINE const Vec4 &vec4(const double *p) { return *reinterpret_cast<const Vec4 *>(p); }

}    // namespace disc

#endif
