/* SPDX-License-Identifier: GPL-2.0-or-later */

// Hard discs in a periodic square: growth without overlap and event chains.  workflow/scene/fluid.py says why and draws
// all random numbers; here are + - * / and sqrt only, so that every machine gives the same bits.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace
{

constexpr int64_t STUCK = 1000000;    // moves of a chain; a ring of touching discs goes on for ever

struct Disc {
  double at[2];      // in [0, length]
  double radius;     // half the distance at which two equal ones touch
  int32_t behind;    // next disc of its cell, -1 at the end
  int32_t cell;
};

struct Cell {
  int32_t at[2];
};

// Discs in square cells wider than the largest distance at which two touch, each cell a chain of discs.
class Gas
{
public:
  std::vector<Disc> discs;

  Gas(int64_t count, const double *position, const double *radius, double widest, double length)
      : discs(count), length(length),
        across(std::max(1.0, std::min(length / (widest * (1.0 + 1e-9)), std::sqrt(double(count))))),
        width(length / across), first(size_t(across) * across, -1)
  {
    for (int64_t i = count - 1; i >= 0; --i) {
      Cell cell;
      for (int k : {0, 1}) {
        discs[i].at[k] = position[2 * i + k];
        cell.at[k] = std::min(int32_t(discs[i].at[k] / width), across - 1);
      }
      discs[i].radius = radius[i];
      insert(i, cell);
    }
  }

  // Largest radius, up to `wanted`, at which disc i overlaps no other.
  double room(int32_t i, double wanted) const
  {
    const Disc &me = discs[i];
    for (int right = -1; right <= 1; ++right)
      for (int up = -1; up <= 1; ++up) {
        double shift[2];
        const Cell cell = image({me.cell % across + right, me.cell / across + up}, shift);
        for (int32_t j = first[index(cell)]; j >= 0; j = discs[j].behind) {
          if (j == i) continue;
          const double x = discs[j].at[0] + shift[0] - me.at[0], y = discs[j].at[1] + shift[1] - me.at[1];
          wanted = std::min(wanted, std::sqrt(x * x + y * y) - discs[j].radius);
        }
      }
    return wanted;
  }

  // Disc i moves along `axis` until it meets another, which moves on in its place, `left` in all; false if it gets
  // stuck.
  bool chain(int32_t i, int axis, double left)
  {
    Cell here{{discs[i].cell % across, discs[i].cell / across}};
    for (int64_t moves = 0; left > 0.0; ++moves) {
      if (moves == STUCK) return false;
      const double border = width * (here.at[axis] + 1);
      double step = std::max(0.0, border - discs[i].at[axis]);
      const bool leaves = step < left;
      step = std::min(step, left);
      const int32_t met = meets(i, axis, here, step);
      left -= step;
      if (met < 0 && leaves) {
        remove(i);
        here.at[axis] = here.at[axis] + 1 < across ? here.at[axis] + 1 : 0;
        discs[i].at[axis] = here.at[axis] ? border : 0.0;
        insert(i, here);
        continue;
      }
      discs[i].at[axis] += step;
      if (met < 0) break;
      i = met;
      here = {{discs[i].cell % across, discs[i].cell / across}};
    }
    return true;
  }

private:
  double length;
  int32_t across;
  double width;
  std::vector<int32_t> first;

  int32_t index(const Cell &cell) const { return cell.at[1] * across + cell.at[0]; }

  void insert(int32_t i, const Cell &cell)
  {
    discs[i].cell = index(cell);
    discs[i].behind = first[discs[i].cell];
    first[discs[i].cell] = i;
  }

  void remove(int32_t i)
  {
    int32_t *link = &first[discs[i].cell];
    while (*link != i)
      link = &discs[*link].behind;
    *link = discs[i].behind;
  }

  // The cell inside the square of which `cell` is an image, and by how much the image is shifted.
  Cell image(Cell cell, double *shift) const
  {
    for (int k : {0, 1}) {
      const int out = cell.at[k] < 0 ? -1 : cell.at[k] >= across ? 1 : 0;
      cell.at[k] -= out * across;
      shift[k] = out * length;
    }
    return cell;
  }

  // The first disc met by disc i within `step`, which becomes the way to it; -1 if there is none.
  int32_t meets(int32_t i, int axis, const Cell &here, double &step) const
  {
    const int other = 1 - axis;
    const Disc me = discs[i];
    int32_t met = -1;
    for (int aside = -1; aside <= 1; ++aside)
      for (int along = 0; along <= 1; ++along) {
        Cell cell = here;
        cell.at[axis] += along;
        cell.at[other] += aside;
        double shift[2];
        cell = image(cell, shift);
        for (int32_t j = first[index(cell)]; j >= 0; j = discs[j].behind) {
          const double far = discs[j].at[axis] + shift[axis] - me.at[axis];
          const double off = discs[j].at[other] + shift[other] - me.at[other];
          const double touch = me.radius + discs[j].radius, under = touch * touch - off * off;
          if (far <= 0.0 || under <= 0.0 || far - touch >= step || j == i) continue;
          const double way = std::max(0.0, far - std::sqrt(under));
          if (way >= step) continue;
          step = way;
          met = j;
        }
      }
    return met;
  }
};

}    // namespace

#define EXPORT extern "C" __attribute__((visibility("default")))

// Each of `count` discs in turn grows as far as the others allow, up to `wanted`; how many are still too small.
EXPORT int64_t hard_discs_grow(int64_t count, const double *position, double *radius, const double *wanted,
                               double widest, double length)
{
  Gas gas(count, position, radius, widest, length);
  int64_t small = 0;
  for (int64_t i = 0; i < count; ++i) {
    radius[i] = gas.discs[i].radius = std::max(radius[i], gas.room(i, wanted[i]));
    small += radius[i] < wanted[i];
  }
  return small;
}

// Event chains of total displacement `way` each, from the disc `start` along `axis`; how many until one got stuck.
EXPORT int64_t hard_discs_chains(int64_t count, double *position, const double *radius, double widest, double length,
                                 int64_t chains, const int32_t *start, const int8_t *axis, double way)
{
  Gas gas(count, position, radius, widest, length);
  int64_t done = 0;
  while (done < chains && gas.chain(start[done], axis[done], way))
    ++done;
  for (int64_t i = 0; i < count; ++i)
    for (int k : {0, 1})
      position[2 * i + k] = gas.discs[i].at[k] < length ? gas.discs[i].at[k] : 0.0;
  return done;
}
