// How far long work has come. Libraries report; whoever listens (a command, on a terminal) shows it.
#pragma once

#include <cstddef>
#include <functional>

namespace opaline {

/// Called with a fraction in [0, 1], at most about a hundred times per piece of work, from any thread
/// but never from two at once.
using ProgressListener = std::function<void(double fraction)>;

/// Replaces the process-wide listener; an empty one silences it. Not while work is running.
void listen_to_progress(ProgressListener listener);

/// While it lives all progress counts from `from` to `to`: of one step of longer work. Not for two steps at once.
class ProgressSpan {
 public:
  ProgressSpan(double from, double to);
  ~ProgressSpan();
  ProgressSpan(const ProgressSpan&) = delete;
  ProgressSpan& operator=(const ProgressSpan&) = delete;
};

/// One piece of work of `total` steps; `advance` may be called from any thread.
class Progress {
 public:
  explicit Progress(std::size_t total);
  void advance(std::size_t steps);

 private:
  std::size_t total_, done_ = 0;
  int shown_ = -1;  // percent
};

}  // namespace opaline
