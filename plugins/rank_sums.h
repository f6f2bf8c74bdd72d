/* SPDX-License-Identifier: GPL-2.0-or-later
   Sums that every rank keeps for itself, such as the energy its contacts dissipated, in a restart file: the number of
   ranks, then the values of each.  A run that resumes on as many ranks goes on with the sums of each, so that the total
   has the same bits; on another number of ranks, rank 0 takes them all. */

#ifndef LMP_DISC_RANK_SUMS_H
#define LMP_DISC_RANK_SUMS_H

#include <mpi.h>

#include <vector>

namespace LAMMPS_NS
{

/* Appends to `state`, which counts on rank 0 alone; collective. */
inline void save_rank_sums(MPI_Comm world, const std::vector<double> &mine, std::vector<double> &state)
{
  int ranks;
  MPI_Comm_size(world, &ranks);
  const int count = static_cast<int>(mine.size());
  state.push_back(ranks);
  state.resize(state.size() + ranks * count);
  MPI_Gather(mine.data(), count, MPI_DOUBLE, state.data() + state.size() - ranks * count, count, MPI_DOUBLE, 0, world);
}

/* The `count` sums of this rank from what save_rank_sums() appended at `saved`. */
inline std::vector<double> restore_rank_sums(MPI_Comm world, const double *saved, int count)
{
  int me, ranks;
  MPI_Comm_rank(world, &me);
  MPI_Comm_size(world, &ranks);
  const int saved_ranks = static_cast<int>(saved[0]);
  const double *const sums = saved + 1;
  if (saved_ranks == ranks) return {sums + count * me, sums + count * (me + 1)};
  std::vector<double> mine(count, 0.0);
  for (int rank = 0; me == 0 && rank < saved_ranks; rank++)
    for (int k = 0; k < count; k++)
      mine[k] += sums[count * rank + k];
  return mine;
}

}    // namespace LAMMPS_NS

#endif
