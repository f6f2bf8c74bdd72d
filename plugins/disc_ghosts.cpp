/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "disc_ghosts.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "force.h"
#include "pair.h"

using namespace LAMMPS_NS;

/* ---- every step ---- */

void DiscGhosts::refresh(std::vector<disc::Grain> &grains, bool all)
{
  if (!known) find();
  requests.clear();
  for (Neighbour &n : neighbours) {
    const Shared &shared = all ? n.all : n.named;
    MPI_Irecv(n.taken.data(), GRAIN * shared.taken.size(), MPI_DOUBLE, n.rank, 0, world, &request());
    double *buf = n.given.data();
    for (const int i : shared.given) {
      const disc::Grain &g = grains[i];
      buf[0] = g.x;
      buf[1] = g.y;
      buf[2] = g.vx;
      buf[3] = g.vy;
      buf[4] = g.w;
      buf += GRAIN;
    }
    MPI_Isend(n.given.data(), GRAIN * shared.given.size(), MPI_DOUBLE, n.rank, 0, world, &request());
  }
  for (const int i : all ? own : own_named) {
    grains[i] = grains[origins[i].index];
    place(grains[i], origins[i]);
  }
  MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  for (const Neighbour &n : neighbours) {
    const double *buf = n.taken.data();
    for (const int i : (all ? n.all : n.named).taken) {
      disc::Grain &g = grains[i];
      g.x = buf[0];
      g.y = buf[1];
      g.vx = buf[2];
      g.vy = buf[3];
      g.w = buf[4];
      g.rw = g.r * g.w;
      place(g, origins[i]);
      buf += GRAIN;
    }
  }
}

void DiscGhosts::place(disc::Grain &g, const Origin &origin) const
{
  g.x += origin.cells[0] * domain->xprd;
  g.y += origin.cells[1] * domain->yprd;
}

void DiscGhosts::collect(std::vector<disc::Action> &actions)
{
  requests.clear();
  for (Neighbour &n : neighbours) {
    MPI_Irecv(n.given.data(), ACTION * n.named.given.size(), MPI_DOUBLE, n.rank, 0, world, &request());
    double *buf = n.taken.data();
    for (const int i : n.named.taken) {
      disc::Action &a = actions[i];
      buf[0] = a.fx;
      buf[1] = a.fy;
      buf[2] = a.moment;
      buf[3] = a.tangential;
      a = disc::Action();
      buf += ACTION;
    }
    MPI_Isend(n.taken.data(), ACTION * n.named.taken.size(), MPI_DOUBLE, n.rank, 0, world, &request());
  }
  for (const int i : own_named) {
    disc::four(&actions[origins[i].index].fx) += disc::four(&actions[i].fx);
    actions[i] = disc::Action();
  }
  MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  for (const Neighbour &n : neighbours) {
    const double *buf = n.given.data();
    for (const int i : n.named.given) {
      disc::Action &a = actions[i];
      a.fx += buf[0];
      a.fy += buf[1];
      a.moment += buf[2];
      a.tangential += buf[3];
      buf += ACTION;
    }
  }
}

/* ---- who is whose ---- */

void DiscGhosts::find()
{
  const int nlocal = atom->nlocal, nall = nlocal + atom->nghost, me = comm->me;
  origins.resize(nall);
  for (int i = 0; i < nlocal; i++)
    origins[i] = {me, i, {0.0, 0.0}};
  comm->forward_comm(force->pair);

  std::vector<std::vector<int>> ghosts(comm->nprocs), indices(comm->nprocs);    // of grains of each rank
  for (int i = nlocal; i < nall; i++) {
    ghosts[origins[i].rank].push_back(i);
    indices[origins[i].rank].push_back(origins[i].index);
  }
  own.swap(ghosts[me]);
  ghosts[me].clear();
  std::vector<int> taken(comm->nprocs), given(comm->nprocs);
  for (int rank = 0; rank < comm->nprocs; rank++)
    taken[rank] = static_cast<int>(ghosts[rank].size());
  MPI_Alltoall(taken.data(), 1, MPI_INT, given.data(), 1, MPI_INT, world);

  neighbours.clear();
  for (int rank = 0; rank < comm->nprocs; rank++)
    if (taken[rank] + given[rank] > 0)
      neighbours.push_back({rank,
                            {std::vector<int>(given[rank]), ghosts[rank]},
                            {},
                            std::vector<double>(GRAIN * given[rank]),
                            std::vector<double>(GRAIN * taken[rank])});
  requests.clear();
  for (Neighbour &n : neighbours) {
    MPI_Irecv(n.all.given.data(), given[n.rank], MPI_INT, n.rank, 0, world, &request());
    MPI_Isend(indices[n.rank].data(), taken[n.rank], MPI_INT, n.rank, 0, world, &request());
  }
  MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  known = true;
}

/* Tells every neighbour which of its grains, by their places in the list of all. */
void DiscGhosts::name(const disc::Contacts &close)
{
  if (!known) find();
  const int nlocal = atom->nlocal;
  named.assign(atom->nghost, 0);
  for (int c = 0; c < close.count; c++)
    for (const int i : {close.i[c], close.j[c]})
      if (i >= nlocal) named[i - nlocal] = 1;
  own_named.clear();
  for (const int i : own)
    if (named[i - nlocal]) own_named.push_back(i);

  std::vector<std::vector<int>> places(neighbours.size());
  requests.clear();
  for (size_t k = 0; k < neighbours.size(); k++) {
    Neighbour &n = neighbours[k];
    n.named.given.resize(n.all.given.size());
    MPI_Irecv(n.named.given.data(), n.named.given.size(), MPI_INT, n.rank, 0, world, &request());
    n.named.taken.clear();
    for (size_t place = 0; place < n.all.taken.size(); place++)
      if (const int i = n.all.taken[place]; named[i - nlocal]) {
        n.named.taken.push_back(i);
        places[k].push_back(static_cast<int>(place));
      }
    MPI_Isend(places[k].data(), places[k].size(), MPI_INT, n.rank, 0, world, &request());
  }
  std::vector<MPI_Status> arrived(requests.size());
  MPI_Waitall(requests.size(), requests.data(), arrived.data());
  for (size_t k = 0; k < neighbours.size(); k++) {
    Neighbour &n = neighbours[k];
    int count;
    MPI_Get_count(&arrived[2 * k], MPI_INT, &count);
    n.named.given.resize(count);
    for (int &i : n.named.given)
      i = n.all.given[i];
  }
}

MPI_Request &DiscGhosts::request()
{
  requests.emplace_back();
  return requests.back();
}

int DiscGhosts::pack(int n, const int *list, double *buf, int pbc_flag, const int *pbc) const
{
  for (int k = 0; k < n; k++, buf += 4) {
    const Origin &origin = origins[list[k]];
    buf[0] = origin.rank;
    buf[1] = origin.index;
    for (int a = 0; a < 2; a++)
      buf[2 + a] = origin.cells[a] + (pbc_flag ? pbc[a] : 0);
  }
  return 4 * n;
}

void DiscGhosts::unpack(int n, int first, const double *buf)
{
  for (int i = first; i < first + n; i++, buf += 4)
    origins[i] = {static_cast<int>(buf[0]), static_cast<int>(buf[1]), {buf[2], buf[3]}};
}
