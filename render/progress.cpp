#include "render/progress.h"

#include <mutex>

namespace opaline {
namespace {

std::mutex mutex;
ProgressListener listener;
double span_begin = 0, span_end = 1;

}  // namespace

void listen_to_progress(ProgressListener new_listener) {
  const std::lock_guard lock(mutex);
  listener = std::move(new_listener);
}

Progress::Progress(std::size_t total) : total_(total) {}

void Progress::advance(std::size_t steps) {
  const std::lock_guard lock(mutex);
  done_ += steps;
  const int percent = total_ ? static_cast<int>(100 * done_ / total_) : 100;
  if (percent == shown_ || !listener) return;
  shown_ = percent;
  listener(span_begin + (span_end - span_begin) * static_cast<double>(percent) / 100);
}

ProgressSpan::ProgressSpan(double from, double to) {
  const std::lock_guard lock(mutex);
  span_begin = from, span_end = to;
}

ProgressSpan::~ProgressSpan() {
  const std::lock_guard lock(mutex);
  span_begin = 0, span_end = 1;
}

}  // namespace opaline
