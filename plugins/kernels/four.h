/* SPDX-License-Identifier: GPL-2.0-or-later
   Four numbers side by side, and how kernels are compiled for several instruction sets. */

#ifndef DISC_KERNELS_FOUR_H
#define DISC_KERNELS_FOUR_H

/* Compiled for several instruction sets (unless DISC_PLAIN is defined); the widest that the machine has is taken when
 * the library is loaded. */
#if !defined(DISC_PLAIN) && defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define DISC_WIDEST __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define DISC_WIDEST
#endif
#define DISC_INLINE inline __attribute__((always_inline))

namespace disc
{

typedef double Four __attribute__((vector_size(32), may_alias));
#if defined(__clang__)
#define DISC_PICK(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
typedef long Places __attribute__((vector_size(32)));
#define DISC_PICK(a, b, i, j, k, l) __builtin_shuffle(a, b, Places{i, j, k, l})
#endif

/* exchange of rows and columns */
DISC_INLINE void transpose(Four &a, Four &b, Four &c, Four &d)
{
  const Four ab0 = DISC_PICK(a, b, 0, 4, 2, 6), ab1 = DISC_PICK(a, b, 1, 5, 3, 7);
  const Four cd0 = DISC_PICK(c, d, 0, 4, 2, 6), cd1 = DISC_PICK(c, d, 1, 5, 3, 7);
  a = DISC_PICK(ab0, cd0, 0, 1, 4, 5);
  b = DISC_PICK(ab1, cd1, 0, 1, 4, 5);
  c = DISC_PICK(ab0, cd0, 2, 3, 6, 7);
  d = DISC_PICK(ab1, cd1, 2, 3, 6, 7);
}

DISC_INLINE Four &four(double *p) { return *reinterpret_cast<Four *>(p); }
DISC_INLINE const Four &four(const double *p) { return *reinterpret_cast<const Four *>(p); }

}    // namespace disc

#endif
