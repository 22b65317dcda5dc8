// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Offline side: read, sanitize, bake, certify. Links CGAL (GPL).

#include <encage/cage.h>
#include <encage/error.h>
#include <encage/mesh.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace encage {

// ---- Files ---------------------------------------------------------------

/// Reads OBJ, PLY, STL, OFF (by CGAL, in double) or glTF/GLB (node transforms
/// applied). Polygons are kept. Throws Error naming file, element and reason;
/// refuses NaN, infinity, indices out of range and files without faces.
PolygonMesh read_polygon_mesh(const std::filesystem::path& file);

/// Writes OBJ, PLY, STL or OFF by the extension, atomically (a temporary in the
/// same folder, then a rename). Coordinates round-trip in double where the
/// format allows. Throws Error.
void write_mesh(const std::filesystem::path& file, const TriangleMesh& mesh);

/// Fans convex polygons, ear-clips others. Vertices are not moved or merged.
TriangleMesh triangulate(const PolygonMesh& polygons);

// ---- Sanitize ------------------------------------------------------------

struct SanitizeReport {
  std::int64_t welded_vertices = 0;       ///< merged with an exactly equal one
  std::int64_t isolated_vertices = 0;     ///< dropped: used by no triangle
  std::int64_t duplicate_triangles = 0;   ///< dropped
  std::int64_t degenerate_triangles = 0;  ///< replaced by thin valid ones
  std::int64_t flipped_components = 0;    ///< turned outward
  std::int64_t capped_loops = 0;          ///< boundary loops closed
};

/// A source made fit for baking. Nothing that was read is moved.
struct SourceMesh {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< input vertex = origin + vertex, exactly
  /// What a cage must enclose, local frame: the triangles as read (welded, duplicates
  /// dropped, degenerate ones kept), then the caps.
  TriangleMesh obstacle;
  std::int64_t cap_count = 0;  ///< the last triangles of `obstacle`
  /// The same surface for the makers: degenerate triangles replaced by thin
  /// valid ones, outward-oriented, caps included.
  TriangleMesh clean;
  Solid solid = Solid::closed;
  double volume = 0;      ///< of the solid, 0 for surface_only
  double diagonal = 0;    ///< of the bounds, > 0
  Hash hash;              ///< of the input as read
  SanitizeReport report;
};

/// Throws Error for empty meshes, non-finite coordinates, meshes whose extent
/// float32 cannot hold, and meshes in a single point.
SourceMesh sanitize(const TriangleMesh& input);

// ---- Certificate ---------------------------------------------------------

/// Why a certificate was refused: one sentence that names elements.
struct CertifyResult {
  bool holds = false;
  std::string reason;       ///< empty if it holds
  Certificate certificate;  ///< method, start and volume_ratio are left to the caller
};

/// Proves, with exact predicates, that `cage` is a closed, oriented 2-manifold
/// without self-intersection, that no triangle of it touches one of `inner`
/// (closed test; degenerate inner triangles count as segments or points) and
/// that every component of `inner` lies inside. `inner_solid` says whether
/// inner's interior has to be inside too (cavities of the cage must not lie in
/// it). The clearance is never above the distance of the surfaces, and below it
/// by no more than a millionth, and rounding of 2^-45 of the triangles' size. Meshes are taken as they are: what they need not be is
/// refused with a reason, never thrown. One thread, re-entrant; about 0.6 us a
/// triangle of `inner`. Shares no geometry code with the makers beyond CGAL.
/// docs/certificate.md says how it is proven.
CertifyResult certify(const TriangleMesh& inner, Solid inner_solid, const TriangleMesh& cage);

enum class Verdict {
  holds,     ///< proven
  refuted,   ///< proven wrong
  unproven,  ///< cannot be decided from what was given
};

const char* name(Verdict verdict) noexcept;

/// What came of checking an asset again.
struct CheckReport {
  struct Check {
    std::string subject;  ///< e.g. "level 2 nesting"
    Verdict verdict = Verdict::unproven;
    std::string detail;   ///< one sentence
  };
  std::vector<Check> checks;

  bool holds() const;  ///< every check does
};

/// Proves every level of a hierarchy again, around the next finer one, and compares
/// the stored certificates. Level 1 is proven around `source` if it is given, which is
/// also compared with what the hierarchy says of it. Without, `hierarchy.fine` stands
/// in: it lies within fine_error of the source, hence a clearance above fine_error
/// carries over; if it is smaller, or no fine mesh is stored, level 1 is unproven.
CheckReport check_asset(const CageHierarchy& hierarchy, const SourceMesh* source = nullptr);

// ---- Bake ----------------------------------------------------------------

enum class BakeMethod { automatic, collapse };
enum class Topology { any, keep, simplify };

struct BakeOptions {
  /// Triangles per level, fine to coarse. Empty: `ratio` and `level_count`; if
  /// these are unset as well, a choice that suits the input's size.
  std::vector<std::int64_t> faces;
  std::optional<double> ratio;      ///< faces of a level / faces of the one before, in (0,1)
  std::optional<int> level_count;
  BakeMethod method = BakeMethod::automatic;
  /// any: whatever is tightest; keep: the genus of the source; simplify: prefer fewer handles.
  Topology topology = Topology::any;
  double min_clearance = 1e-5;      ///< distance between consecutive surfaces, in diagonals of the source
  int threads = 0;                  ///< 0: all; never changes the result
  std::optional<double> time_limit; ///< seconds; the only option that may make results vary
  bool keep_fine = true;            ///< store level 0 in the hierarchy
};

/// Progress, cancellation and messages. The functions are called from the
/// thread that called bake(), at least ten times a second.
struct BakeContext {
  /// fraction in [0,1] of the whole job, and what is being done now.
  std::function<void(double fraction, std::string_view stage)> progress;
  std::function<void(std::string_view message)> log;
  /// Set from any thread or a signal handler; noticed within about a second.
  std::atomic<bool>* cancel = nullptr;
};

/// What one bake measured; never stored in the hierarchy.
struct BakeReport {
  struct Level {
    double seconds = 0;
  };
  std::vector<Level> levels;
  double seconds = 0;
};

/// Nested, certified cages around `source`. Levels with as many faces as the
/// one before are skipped with a log message; a source too small for every
/// level gets its hull. Throws Error or Cancelled.
CageHierarchy bake(const SourceMesh& source, const BakeOptions& options, const BakeContext& context,
                   BakeReport* report = nullptr);
CageHierarchy bake(const TriangleMesh& input, const BakeOptions& options,
                   const BakeContext& context = {}, BakeReport* report = nullptr);

}  // namespace encage
