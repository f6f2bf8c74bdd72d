/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_DISC_GHOSTS_H
#define LMP_DISC_GHOSTS_H

#include "kernels/sweep.h"
#include "pointers.h"

#include <mpi.h>
#include <vector>

namespace LAMMPS_NS
{

/* LAMMPS's ghosts among the kernel's grains and actions.

   Each is copied straight from its grain, with one message per neighbouring rank and step, all of them under way at the
   same time; LAMMPS's own communication goes axis by axis, one message after the other.  Between two choices of close
   pairs only the ghosts that these name are copied.  Every call is collective. */
class DiscGhosts : protected Pointers
{
public:
  explicit DiscGhosts(class LAMMPS *lmp) : Pointers(lmp) {}
  void forget() { known = false; }                       // LAMMPS chose the ghosts anew
  void refresh(std::vector<disc::Grain> &, bool all);    // grains to ghosts: all, or those named
  void name(const disc::Contacts &);                     // ghosts that act from now on
  void collect(std::vector<disc::Action> &);    // what acts on these to their grains; none is left on the ghosts

  // the pair style's part in LAMMPS's communication, which tells every ghost its origin
  int pack(int n, const int *list, double *buf, int pbc_flag, const int *pbc) const;
  void unpack(int n, int first, const double *buf);

private:
  struct Origin {
    int rank, index;    // its grain, there
    double cells[2];    // lengths of the cell from there
  };
  struct Shared {                     // with another rank
    std::vector<int> given, taken;    // grains of this rank with ghosts there; ghosts here of grains there
  };
  struct Neighbour {
    int rank;
    Shared all, named;
    std::vector<double> given, taken;    // records on the wire
  };
  static constexpr int GRAIN = 5, ACTION = 4;    // doubles on the wire

  void find();
  MPI_Request &request();
  void place(disc::Grain &, const Origin &) const;

  bool known = false;
  std::vector<Origin> origins;        // of all grains and ghosts
  std::vector<int> own, own_named;    // ghosts of grains of this rank
  std::vector<Neighbour> neighbours;
  std::vector<char> named;    // of ghosts
  std::vector<MPI_Request> requests;
};

}    // namespace LAMMPS_NS

#endif
