// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Offline side: read, sanitize, bake, certify. Links CGAL (GPL).

#include <encage/cage.h>
#include <encage/decimator.h>
#include <encage/energy.h>
#include <encage/error.h>
#include <encage/export.h>
#include <encage/mesh.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ENCAGE_EXPORT encage {

// ---- Files ---------------------------------------------------------------

/// What a reader skipped or put up with: one short sentence each, for the user.
using ReadNotes = std::vector<std::string>;

/// Reads OBJ, PLY, STL (both in text and binary), OFF (text) or glTF/GLB, in double and by the extension
/// (docs/formats.md). Polygons are kept; points and lines are skipped. STL vertices with equal coordinates are shared.
/// Of glTF, all triangles of the default scene in its default pose: instances, node transforms, morph targets with
/// their default weights, skins as their joints stand. Appends to `notes` unless it is null. Throws Error naming file,
/// element (counted from 0), line and reason; refuses NaN, infinity, indices out of range, truncated files, files
/// without faces, and glTF extensions that a file requires and the reader does not know.
PolygonMesh read_polygon_mesh(const std::filesystem::path& file, ReadNotes* notes = nullptr);

/// The same from memory. `format` is an extension without its dot; `name` stands for the file in messages, and files
/// that the bytes refer to lie beside it.
PolygonMesh decode_polygon_mesh(std::string_view bytes, const std::string& format, const std::filesystem::path& name,
                                ReadNotes* notes = nullptr);

/// read_polygon_mesh(), triangulated.
TriangleMesh read_mesh(const std::filesystem::path& file, ReadNotes* notes = nullptr);

/// Writes OBJ, PLY, STL or OFF by the extension. A regular file is replaced whole or left untouched (a temporary in the
/// same folder, then a rename), a link stays a link, devices and pipes are written to. Coordinates round-trip in double
/// where the format allows. Throws Error.
void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh);
/// The same in the format named: "obj", "ply", "stl" or "off".
void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh, const std::string& format);

/// Fans convex polygons, ear-clips others; n corners give n - 2 triangles, in the order of the polygons. Vertices are
/// not moved or merged. Throws Error for a polygon with fewer than 3 corners.
TriangleMesh triangulate(const PolygonMesh& polygons);

// ---- Sanitize ------------------------------------------------------------

struct SanitizeReport {
  std::int64_t welded_vertices = 0;       ///< merged with an exactly equal one
  std::int64_t isolated_vertices = 0;     ///< dropped: used by no triangle
  std::int64_t duplicate_triangles = 0;   ///< dropped: on the vertices of an earlier one
  std::int64_t degenerate_triangles = 0;  ///< replaced in `clean` by valid ones
  std::int64_t flipped_components = 0;    ///< turned outward, or made consistent in themselves
  std::int64_t capped_loops = 0;          ///< boundary loops closed
};

/// A source made fit for baking. Nothing that was read is moved.
struct SourceMesh {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< input vertex = origin + vertex, exactly
  /// What a cage must enclose, local frame: the points of all triangles as read, then the caps. Welded, oriented as
  /// `clean`, duplicates dropped; degenerate triangles are kept, those that hang on to the surface as the segment (a,
  /// b, b) that they are. is_closed() holds unless `solid` is surface_only. Every vertex is used.
  TriangleMesh obstacle;
  std::int64_t cap_count = 0;  ///< the last triangles of `obstacle`
  /// The same surface for the makers, without degenerate triangles, caps included: a degenerate triangle in a seam is
  /// flipped away (the same points), another one is replaced by thin valid ones that contain it. Closed components are
  /// oriented outward (cavities inward).
  TriangleMesh clean;
  /// `clean` is a closed, consistently oriented 2-manifold: every edge has exactly two triangles, every vertex one fan.
  /// It may intersect itself.
  bool manifold = false;
  /// capped only if the caps enclose a volume. Flat sheets, and surfaces with an edge of several triangles that do not
  /// cancel, are surface_only and get no caps.
  Solid solid = Solid::closed;
  double volume = 0;    ///< of the solid, > 0, parts that overlap counted once; 0 for surface_only
  double diagonal = 0;  ///< of the bounds, > 0
  Hash hash;            ///< of the vertices and triangles as passed to sanitize()
  SanitizeReport report;
};

/// Two triangles on the same vertices with opposite orientation are duplicates as well (the first stays), unless the
/// surface is closed only with both of them. Throws Error for meshes without triangles, non-finite coordinates, indices
/// out of range, meshes in a single point, and an extent above 1e37 or below 1e-30, which float32 cannot hold. Takes
/// linear time but for unusual holes.
SourceMesh sanitize(const TriangleMesh& input);

// ---- Certificate ---------------------------------------------------------

/// Why a certificate was refused: one sentence that names elements.
struct CertifyResult {
  bool holds = false;
  std::string reason;       ///< empty if it holds
  Certificate certificate;  ///< method, start, volume_ratio and the distances are left to the caller
};

/// Proves, with exact predicates, that `cage` is a closed, oriented 2-manifold without self-intersection, that no
/// triangle of it touches one of `inner` (closed test; degenerate inner triangles count as segments or points) and that
/// every component of `inner` lies inside. `inner_solid` says whether inner's interior has to be inside too (cavities
/// of the cage must not lie in it). The clearance is never above the distance of the surfaces, and below it by no more
/// than a millionth, and rounding of 2^-45 of the triangles' size. Meshes are taken as they are: what they need not be
/// is refused with a reason, never thrown. One thread, re-entrant; about 0.6 us a triangle of `inner`. Shares no
/// geometry code with the makers beyond CGAL. docs/certificate.md says how it is proven.
CertifyResult certify(const TriangleMesh& inner, Solid inner_solid, const TriangleMesh& cage);

/// How far a cage is from a surface: bounds from above.
struct DistanceBounds {
  double max_distance = 0;   ///< of the cage's points from the surface, a length
  double mean_distance = 0;  ///< over the cage's area, a length
};

/// Bounds the distances of the cage's points from a surface; neither has to be closed. The cage's triangles are split
/// until two convex functions above the distance, linear between the corners of a piece, bound it: the distance to one
/// triangle of the surface, and the way to a patch of the surface under the piece. Rounding is added. The bounds end
/// within some 1 % of the values, unless that takes too many splits (16,000, and 10 for each triangle of the cage):
/// then they hold, but may be looser. One thread, always the same result. Throws Error for meshes without triangles;
/// indices must be valid. docs/certificate.md says more.
DistanceBounds distance_bounds(const TriangleMesh& surface, const TriangleMesh& cage);

enum class CheckVerdict {
  holds,     ///< proven
  refuted,   ///< proven wrong
  unproven,  ///< cannot be decided from what was given
};

const char* name(CheckVerdict verdict) noexcept;

/// The result of check_asset().
struct CheckReport {
  struct Check {
    std::string subject;  ///< e.g. "level 2 nesting"
    CheckVerdict verdict = CheckVerdict::unproven;
    std::string detail;  ///< one sentence
  };
  std::vector<Check> checks;

  bool holds() const;  ///< every check does
};

/// Proves every level of a hierarchy again, around the next finer one, and compares the stored certificates. Level 1 is
/// proven around `source` if it is given, which is also compared with what the hierarchy says of it. Without,
/// `hierarchy.fine` stands in: it lies within fine_error of the source, hence a clearance above fine_error carries
/// over; if it is smaller, or no fine mesh is stored, level 1 is unproven.
CheckReport check_asset(const CageHierarchy& hierarchy, const SourceMesh* source = nullptr);

// ---- Bake ----------------------------------------------------------------

enum class BakeMethod { automatic, collapse, flow };
enum class Topology { any, keep, simplify };
/// How the re-inflation moves F back home: in a straight line, or along the flow's history as in the paper.
enum class FlowPath { straight, history };

struct BakeOptions {
  /// Triangles per level, fine to coarse, at least 4. Empty: `ratio` and `level_count` decide; if these are unset as
  /// well, Encage chooses by the input's size.
  std::vector<std::int64_t> faces;
  std::optional<double> ratio;  ///< faces of a level / faces of the one before, in (0,1)
  std::optional<int> level_count;
  BakeMethod method = BakeMethod::automatic;
  /// any takes what is tightest; keep keeps the genus of the source; simplify prefers fewer handles.
  Topology topology = Topology::any;
  /// Makes the coarse meshes of the flow; excludes the method collapse. Empty: regular, then adaptive, and alpha wraps
  /// where both fail.
  Decimator decimator;
  std::string decimator_name;  ///< the name that the asset records: "regular", "adaptive" or one of yours
  /// Coarse meshes of yours for the flow instead of decimations, fine to coarse, in the source's frame; closed,
  /// oriented, manifold and free of self-intersection. Excludes `faces`, `ratio`, `level_count`, `decimator` and the
  /// method collapse.
  std::vector<TriangleMesh> coarse;
  std::vector<std::string> coarse_names;  ///< names of `coarse` in messages; may be empty
  /// Energies of the flow; they exclude the method collapse.
  EnergyPtr energy_inflate;  ///< minimised while F moves back home; null: step_energy()
  EnergyPtr energy_final;    ///< minimised afterwards; null: volume_energy()
  FlowPath path = FlowPath::straight;
  bool keep_partial = false;  ///< if a level fails, return the levels made before it (at least one) instead of throwing
  double min_clearance = 1e-5;       ///< distance between consecutive surfaces, in diagonals of the source
  int threads = 0;                   ///< 0: all; never changes the result
  std::optional<double> time_limit;  ///< seconds, above 0; the only option that may make results vary
  bool keep_fine = true;             ///< store level 0 in the hierarchy
};

/// Progress, cancellation and messages. The functions are called from the thread that called bake(), at least ten times
/// a second.
struct BakeContext {
  /// fraction in [0,1] of the whole job, and what is being done now.
  std::function<void(double fraction, std::string_view stage)> progress;
  /// What concerns the caller: levels that were asked for and are not made.
  std::function<void(std::string_view message)> log;
  /// How the makers get on: what failed, and what they tried instead.
  std::function<void(std::string_view message)> trace;
  /// Set from any thread or a signal handler; noticed within about a second, or when a running alpha wrap (seconds, on
  /// large inputs) ends.
  std::atomic<bool>* cancel = nullptr;
};

/// What one bake measured; never stored in the hierarchy.
struct BakeReport {
  struct Level {
    double seconds = 0;
    double flow_seconds = 0;       ///< 0 if the level was made by collapse
    double reinflate_seconds = 0;  ///< with the final minimisation
  };
  std::vector<Level> levels;  ///< one for each level of the hierarchy returned
  double seconds = 0;
  /// What was asked for and is not there, and why: with keep_partial the level that failed, or a level_count that is
  /// not reached; levels that a time limit left out. Else empty. Also set where bake() throws because a level failed.
  std::string failure;
  std::vector<std::int64_t> missing;  ///< faces of the levels that failed or were left out, fine to coarse
};

/// Nested, certified cages around `source`. A closed surface gets no level with more faces than it has; levels with as
/// many faces as the one before are skipped with a log message. Throws Error or Cancelled.
CageHierarchy bake(const SourceMesh& source, const BakeOptions& options, const BakeContext& context,
                   BakeReport* report = nullptr);
CageHierarchy bake(const TriangleMesh& input, const BakeOptions& options, const BakeContext& context = {},
                   BakeReport* report = nullptr);

/// write_asset(), but the file is read back before it takes its name: what was certified is what stands in the file,
/// bit by bit. Throws Error naming the file, and then leaves an older file of that name, and no temporary.
void write_certified_asset(const std::filesystem::path& file, const CageHierarchy& hierarchy);

}  // namespace encage
