// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"
#include "cagegen/threads/control.h"
#include "cagegen/threads/journal.h"

#include <encage/bake.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace encage {

/// A level to make.
struct LevelJob {
  makers::LevelRequest request;
  Solid solid = Solid::closed;               ///< what the inner mesh bounds
  const TriangleMesh* coarse = nullptr;      ///< of the flow: made by the user, local frame
  const TriangleMesh* undeformed = nullptr;  ///< the inner mesh as decimated, if it was made by flow
  std::optional<int> genus;                  ///< of the inner mesh; no value if it is no closed manifold
  bool expendable = false;                   ///< there are levels already: this one may be left out when time is up
};

/// The work on one level: what the methods make competes, and the tightest that is certified wins.
class LevelWork {
 public:
  struct Result {
    makers::Candidate candidate;
    Certificate certificate;
  };

  /// Refers to its arguments, and to what the job points to.
  LevelWork(const LevelJob& job, const BakeOptions& options, Journal& journal, const makers::Control& whole);

  /// No value if nothing came of it, or if time was up: failure() is empty then. Throws Cancelled.
  std::optional<Result> run();
  const std::string& failure() const { return failure_; }

  /// From any thread, while run() runs. Stops the flow, if there will be a level without it or need not be one.
  void time_is_up();
  double fraction() const;

 private:
  struct Maker {
    std::unique_ptr<makers::CandidateMaker> maker;
    makers::Control* control;
    bool bounds_others = false;  ///< asked only where the others have nothing that is tighter than all it can make
  };
  struct Contender {
    makers::Candidate candidate;
    makers::CandidateMaker* maker;
    bool finished = false;
  };

  std::vector<Maker> makers(const makers::Obstacle& obstacle);
  bool topology_suits(const Certificate& certificate, const makers::Candidate& candidate);
  void begin_finishing();
  std::vector<Contender> next_batch(const std::vector<Maker>& makers);
  std::vector<makers::Candidate> next_of(const Maker& maker);
  std::optional<Result> tightest(std::vector<Contender> contenders);
  void finish_best(std::vector<Contender>& contenders);
  std::optional<Certificate> accept(const makers::Candidate& candidate);

  const LevelJob& job_;
  const BakeOptions& options_;
  Journal& journal_;
  makers::Control collapse_, flow_;
  makers::LevelRequest collapse_request_, flow_request_;
  bool collapses_, flows_;
  std::mutex stage_mutex_;  ///< guards what time_is_up() decides: nothing is stopped once finishing has begun
  std::atomic<bool> finishing_{false};
  bool gave_up_ = false;  ///< the flow was stopped in this batch or one before
  std::string handles_;   ///< why the last candidate with too many or too few handles was refused
  std::string refused_;   ///< the start of the last candidate that the certificate refused
  std::mutex failed_mutex_;
  std::string failed_;  ///< what a maker threw last
  std::string failure_;
};

}  // namespace encage
