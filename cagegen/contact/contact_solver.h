// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/obstacle.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace encage::makers {

struct ContactSolverOptions {
  double clearance = 0;                 ///< distance to the obstacle, a length
  double self_clearance = 0;            ///< distance between faces of the cage that share no vertex, a length
  int threads = 1;                      ///< never changes the result
  std::function<void()> check = [] {};  ///< called often; may throw to cancel
};

/// Moves a cage from one valid state to the next. A state is valid if the cage keeps `clearance` to the obstacle, faces
/// keep `self_clearance` to each other (or what they had at the start), neighbours do not fold onto each other, and one
/// point of each component of the obstacle is inside. A certificate asks for the same. Validity is a property of the
/// state alone, not of the step that led there: a surface that had passed through another one on the way would now be
/// outside, or touch, and the test of the whole state finds that.
class ContactSolver {
 public:
  using Positions = std::vector<Point>;

  /// `cage` must be valid around the obstacle of the first step.
  ContactSolver(const TriangleMesh& cage, ContactSolverOptions options);

  const Positions& positions() const { return position_; }
  const ContactSolverOptions& options() const { return options_; }
  void set_self_clearance(double length) { options_.self_clearance = length; }
  TriangleMesh mesh() const;
  std::size_t face_count() const { return face_.size(); }
  const std::array<std::int32_t, 3>& face(std::size_t f) const { return face_[f]; }

  /// A valid state as near to `wanted` as the contacts allow, with the obstacle at rest; vertices that would still
  /// touch stay where they are. `weights`, one a vertex, weigh the squares of the distances; empty: all alike.
  Positions approach(const Obstacle& obstacle, const Positions& wanted, const std::vector<double>& weights = {});

  /// The same while the obstacle, one mesh, moves from `before`, where the present state is valid, to `after`. No value
  /// if faces still touch; jammed() then lists them. A `reach` above 0 puts planes between all triangles nearer than
  /// that before they meet, which is slow, and succeeds for small motions.
  std::optional<Positions> follow(const Obstacle& before, const Obstacle& after, const Positions& wanted,
                                  double reach = 0);
  const std::vector<std::int32_t>& jammed() const { return jammed_; }

  /// True if a step from the present state to `positions`, free of contacts, has not jumped over a whole component of
  /// the obstacle.
  bool encloses_all(const Obstacle& obstacle, const Positions& positions);
  /// True if a point is inside one component of the cage at `positions`, and inside of it only.
  bool encloses(const Positions& positions, const Point& x) const;
  void commit(Positions positions) { position_ = std::move(positions); }

  /// Faces tested so far: the unit of work budgets.
  std::int64_t work() const { return work_; }

 private:
  using Index3 = std::array<std::int32_t, 3>;

  /// A face of the cage and what it met: an obstacle triangle, or (negative: -1 - face) a later face.
  struct Pair {
    std::int32_t face;
    std::int32_t other;
    friend auto operator<=>(const Pair&, const Pair&) = default;
  };

  /// sum over k of weight[k] normal . Y[vertex[k]] >= offset
  struct Contact {
    Pair pair;
    Point normal;
    std::array<std::int32_t, 6> vertex;
    std::array<double, 6> weight;
    int count;
    double offset;
    double multiplier = 0;
    double response = 0;  ///< change of the distance for a multiplier of 1
    double move = 0;      ///< length by which the vertices move for a multiplier of 1
  };

  struct Step {
    const Obstacle& before;
    const Obstacle& after;
    bool moves;
    double reach;
  };

  Corners corners(const Positions& y, std::int32_t f) const { return {y[face_[f][0]], y[face_[f][1]], y[face_[f][2]]}; }
  void fit_box(const Positions& y, std::int32_t f);
  void begin(const Step& step);
  bool resolve(const Step& step, const Positions& wanted, Positions& y);
  void project(const Positions& wanted, int sweeps, Positions& y);
  void add_contact(const Step& step, const Pair& pair, bool strict);
  void add(Contact& c);
  void add_obstacle_contact(const Step& step, const Pair& pair, bool strict);
  void add_self_contact(const Pair& pair, bool strict);
  void add_pair(const Pair& pair, const Point& normal, std::int32_t a, std::int32_t b, double gap);
  void add_all_near(const Step& step);
  void retest(const Step& step, const Positions& y);
  void test_face(const Step& step, const Positions& y, std::int32_t f, std::vector<Pair>& found,
                 std::vector<std::int32_t>& scratch) const;
  void retreat(const Step& step, Positions& y);
  void add_lost_cones(const Positions& y);

  ContactSolverOptions options_;
  Positions position_;
  std::vector<Index3> face_;
  std::vector<std::vector<std::int32_t>> incident_;  ///< faces of each vertex
  TriangleTree tree_;                                ///< of the faces as tested last
  std::vector<Eigen::AlignedBox3d> box_;
  Positions tested_;
  double magnitude_ = 0;     ///< largest coordinate of the positions tested last
  std::vector<bool> dirty_;  ///< faces that moved since the last test
  bool test_all_ = false;    ///< the obstacle has moved and no face has been tested against it
  std::vector<Pair> hits_;   ///< of the positions tested last, sorted
  std::vector<Pair> known_;  ///< pairs with a contact, sorted
  std::vector<Pair> strict_;
  std::vector<Contact> contacts_;
  std::vector<double> mobility_;        ///< per vertex: 1 / weight
  std::vector<std::int64_t> moved_at_;  ///< per vertex: the change in project() that moved it last
  std::vector<std::int64_t> seen_at_;   ///< per contact: the change after which it was looked at
  std::vector<std::int32_t> jammed_;
  std::int64_t work_ = 0;
};

}  // namespace encage::makers
