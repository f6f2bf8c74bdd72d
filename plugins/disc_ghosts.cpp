/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "disc_ghosts.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "force.h"
#include "pair.h"

using namespace LAMMPS_NS;

/* ---- every step ---- */

void DiscGhosts::forward_comm(std::vector<disc::Grain> &grains, bool all)
{
  if (!known) find_owners();
  requests.clear();
  for (NeighborRank &n : ranks) {
    const Exchange &exchange = all ? n.all : n.selected;
    MPI_Irecv(n.recv.data(), GRAIN * exchange.recv.size(), MPI_DOUBLE, n.rank, 0, world, &request());
    double *buf = n.send.data();
    for (const int i : exchange.send) {
      const disc::Grain &g = grains[i];
      buf[0] = g.x;
      buf[1] = g.y;
      buf[2] = g.vx;
      buf[3] = g.vy;
      buf[4] = g.w;
      buf += GRAIN;
    }
    MPI_Isend(n.send.data(), GRAIN * exchange.send.size(), MPI_DOUBLE, n.rank, 0, world, &request());
  }
  for (const int i : all ? own : own_selected) {
    grains[i] = grains[owners[i].index];
    shift_to_image(grains[i], owners[i]);
  }
  MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  for (const NeighborRank &n : ranks) {
    const double *buf = n.recv.data();
    for (const int i : (all ? n.all : n.selected).recv) {
      disc::Grain &g = grains[i];
      g.x = buf[0];
      g.y = buf[1];
      g.vx = buf[2];
      g.vy = buf[3];
      g.w = buf[4];
      g.rw = g.r * g.w;
      shift_to_image(g, owners[i]);
      buf += GRAIN;
    }
  }
}

void DiscGhosts::shift_to_image(disc::Grain &g, const Owner &owner) const
{
  g.x += owner.cells[0] * domain->xprd;
  g.y += owner.cells[1] * domain->yprd;
}

void DiscGhosts::reverse_comm(std::vector<disc::GrainForce> &forces)
{
  requests.clear();
  for (NeighborRank &n : ranks) {
    MPI_Irecv(n.send.data(), FORCE * n.selected.send.size(), MPI_DOUBLE, n.rank, 0, world, &request());
    double *buf = n.recv.data();
    for (const int i : n.selected.recv) {
      disc::GrainForce &f = forces[i];
      buf[0] = f.fx;
      buf[1] = f.fy;
      buf[2] = f.moment;
      buf[3] = f.tangential;
      f = disc::GrainForce();
      buf += FORCE;
    }
    MPI_Isend(n.recv.data(), FORCE * n.selected.recv.size(), MPI_DOUBLE, n.rank, 0, world, &request());
  }
  for (const int i : own_selected) {
    disc::vec4(&forces[owners[i].index].fx) += disc::vec4(&forces[i].fx);
    forces[i] = disc::GrainForce();
  }
  MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  for (const NeighborRank &n : ranks) {
    const double *buf = n.send.data();
    for (const int i : n.selected.send) {
      disc::GrainForce &f = forces[i];
      f.fx += buf[0];
      f.fy += buf[1];
      f.moment += buf[2];
      f.tangential += buf[3];
      buf += FORCE;
    }
  }
}

/* ---- who is whose ---- */

void DiscGhosts::find_owners()
{
  const int nlocal = atom->nlocal, nall = nlocal + atom->nghost, me = comm->me;
  owners.resize(nall);
  for (int i = 0; i < nlocal; i++)
    owners[i] = {me, i, {0.0, 0.0}};
  comm->forward_comm(force->pair);

  std::vector<std::vector<int>> ghosts(comm->nprocs), indices(comm->nprocs);    // of grains of each rank
  for (int i = nlocal; i < nall; i++) {
    ghosts[owners[i].rank].push_back(i);
    indices[owners[i].rank].push_back(owners[i].index);
  }
  own.swap(ghosts[me]);
  ghosts[me].clear();
  std::vector<int> recv(comm->nprocs), send(comm->nprocs);
  for (int rank = 0; rank < comm->nprocs; rank++)
    recv[rank] = static_cast<int>(ghosts[rank].size());
  MPI_Alltoall(recv.data(), 1, MPI_INT, send.data(), 1, MPI_INT, world);

  ranks.clear();
  for (int rank = 0; rank < comm->nprocs; rank++)
    if (recv[rank] + send[rank] > 0)
      ranks.push_back({rank,
                       {std::vector<int>(send[rank]), ghosts[rank]},
                       {},
                       std::vector<double>(GRAIN * send[rank]),
                       std::vector<double>(GRAIN * recv[rank])});
  requests.clear();
  for (NeighborRank &n : ranks) {
    MPI_Irecv(n.all.send.data(), send[n.rank], MPI_INT, n.rank, 0, world, &request());
    MPI_Isend(indices[n.rank].data(), recv[n.rank], MPI_INT, n.rank, 0, world, &request());
  }
  MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE);
  known = true;
}

/* Tells every neighbouring rank which of its grains, by their places in the list of all. */
void DiscGhosts::select_ghosts(const disc::ActivePairs &active)
{
  if (!known) find_owners();
  const int nlocal = atom->nlocal;
  selected.assign(atom->nghost, 0);
  for (int c = 0; c < active.count; c++)
    for (const int i : {active.i[c], active.j[c]})
      if (i >= nlocal) selected[i - nlocal] = 1;
  own_selected.clear();
  for (const int i : own)
    if (selected[i - nlocal]) own_selected.push_back(i);

  std::vector<std::vector<int>> places(ranks.size());
  requests.clear();
  for (size_t k = 0; k < ranks.size(); k++) {
    NeighborRank &n = ranks[k];
    n.selected.send.resize(n.all.send.size());
    MPI_Irecv(n.selected.send.data(), n.selected.send.size(), MPI_INT, n.rank, 0, world, &request());
    n.selected.recv.clear();
    for (size_t place = 0; place < n.all.recv.size(); place++)
      if (const int i = n.all.recv[place]; selected[i - nlocal]) {
        n.selected.recv.push_back(i);
        places[k].push_back(static_cast<int>(place));
      }
    MPI_Isend(places[k].data(), places[k].size(), MPI_INT, n.rank, 0, world, &request());
  }
  std::vector<MPI_Status> arrived(requests.size());
  MPI_Waitall(requests.size(), requests.data(), arrived.data());
  for (size_t k = 0; k < ranks.size(); k++) {
    NeighborRank &n = ranks[k];
    int count;
    MPI_Get_count(&arrived[2 * k], MPI_INT, &count);
    n.selected.send.resize(count);
    for (int &i : n.selected.send)
      i = n.all.send[i];
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
    const Owner &owner = owners[list[k]];
    buf[0] = owner.rank;
    buf[1] = owner.index;
    for (int a = 0; a < 2; a++)
      buf[2 + a] = owner.cells[a] + (pbc_flag ? pbc[a] : 0);
  }
  return 4 * n;
}

void DiscGhosts::unpack(int n, int first, const double *buf)
{
  for (int i = first; i < first + n; i++, buf += 4)
    owners[i] = {static_cast<int>(buf[0]), static_cast<int>(buf[1]), {buf[2], buf[3]}};
}
