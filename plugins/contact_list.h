/* SPDX-License-Identifier: GPL-2.0-or-later
   One neighbouring pair of discs: everything a kernel needs of it, in one cache line. */

#ifndef DISC_CONTACT_LIST_H
#define DISC_CONTACT_LIST_H

#include "kernels/cohesive.h"

namespace disc
{

struct alignas(64) Neighbours {
  int i, j;           // local indices of this list; i is owned here, j may be a ghost
  double ri, rj;      // radii
  double eta;         // viscosity of the pair
  Springs springs;    // of the contact, zero while it is open
  double viscous;     // N_v of the last force evaluation, zero while the contact is open

  bool remembers() const { return springs.stretch != 0.0 || springs.rotation != 0.0 || viscous != 0.0; }
  void forget()
  {
    springs = {0.0, 0.0};
    viscous = 0.0;
  }
};
static_assert(sizeof(Neighbours) == 64, "one pair fills one cache line");

}    // namespace disc

#endif
