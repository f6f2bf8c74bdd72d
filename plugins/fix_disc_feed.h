/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_FEED_H
#define LMP_FIX_DISC_FEED_H

#include "fix.h"

#include <vector>

namespace LAMMPS_NS
{

// clang-format off
/* fix ID group disc/feed N FILE type t mass m gravity g height h [ahead a]

   Particle insertion: each grain falls from rest at height h, under the gravity g, from the time that FILE gives it.
   Lines of FILE: tag, time, x, diameter; times increase.  A grain that falls freely is no atom: its place is known in
   closed form.  Every N steps a grain that is closer than `a` (default 3) to where an atom of the group could meet it
   is inserted: it becomes an atom of type t in the group, of mass m diameter^2, with the place and the velocity that
   the fall has given it.  Waiting until then changes nothing but the cost, as long as no pair closes in by more than a
   within N steps.

   Atoms of the group that come within 1 of the sides or of the lower face of the box are removed.

   Vector: 1 grains still to be released or falling; 2 grains inserted; 3 grains removed; 4 energy brought in, the sum
   of m g h; 5 energy taken out with removed grains (kinetic and m g y); 6 height of the highest atom of the group. */
// clang-format on
class FixDiscFeed : public Fix
{
public:
  FixDiscFeed(class LAMMPS *, int, char **);
  int setmask() override;
  void init() override;
  void post_integrate() override;
  void pre_exchange() override;
  double compute_vector(int) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

private:
  struct Grain {
    tagint tag;
    double time, x, diameter;
  };
  struct Counts {
    double inserted = 0.0, removed = 0.0, energy_in = 0.0, energy_out = 0.0;
  };

  void read(const char *file);
  double now() const;
  double fall_time(const Grain &) const;
  bool is_near(const Grain &) const;
  bool has_left(int i) const;
  void insert(const Grain &);
  void remove_grains();

  std::vector<Grain> grains;
  Counts counts;
  size_t ready = 0;    // grains that are to be atoms after the next rebuild
  int type = 0;
  double mass = 1.0, gravity = 1.0, height = 0.0, ahead = 3.0;
};

}    // namespace LAMMPS_NS

#endif
