/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_DISC_GHOSTS_H
#define LMP_DISC_GHOSTS_H

#include "kernels/pair_loop.h"
#include "pointers.h"

#include <mpi.h>
#include <vector>

namespace LAMMPS_NS
{

/* LAMMPS's ghosts among the kernel's grains and forces.

   Each is copied straight from its grain, with one message per neighbouring rank and step, all of them under way at the
   same time; LAMMPS's own communication goes axis by axis, one message after the other.  Between two rebuilds of the
   active pair list only the ghosts of active pairs are copied.  Every call is collective. */
class DiscGhosts : protected Pointers
{
public:
  explicit DiscGhosts(class LAMMPS *lmp) : Pointers(lmp) {}
  void invalidate() { known = false; }                        // LAMMPS chose the ghosts anew
  void select_ghosts(const disc::ActivePairs &);              // those of these pairs act from now on
  void forward_comm(std::vector<disc::Grain> &, bool all);    // grains to ghosts: all, or the selected ones
  void reverse_comm(std::vector<disc::GrainForce> &);         // forces of selected ghosts to their grains; then zero

  // the pair style's part in LAMMPS's communication, which tells every ghost its owner
  int pack(int n, const int *list, double *buf, int pbc_flag, const int *pbc) const;
  void unpack(int n, int first, const double *buf);

private:
  struct Owner {
    int rank, index;    // of the grain, there
    double cells[2];    // lengths of the cell from there
  };
  struct Exchange {                 // with another rank, named for forward_comm; reverse_comm goes the other way
    std::vector<int> send, recv;    // grains of this rank with ghosts there; ghosts here of grains there
  };
  struct NeighborRank {
    int rank;
    Exchange all, selected;
    std::vector<double> send, recv;    // records on the wire
  };
  static constexpr int GRAIN = 5, FORCE = 4;    // doubles on the wire

  void find_owners();
  MPI_Request &request();
  void shift_to_image(disc::Grain &, const Owner &) const;

  bool known = false;
  std::vector<Owner> owners;             // of all grains and ghosts
  std::vector<int> own, own_selected;    // ghosts of grains of this rank
  std::vector<NeighborRank> ranks;
  std::vector<char> selected;    // of ghosts
  std::vector<MPI_Request> requests;
};

}    // namespace LAMMPS_NS

#endif
