#include "report/log/channel_course.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stillframe::report {

bool is_odd(const ChannelCourse& course, double inside, double outside) {
  // At its turning points a sine of 2^15 steps rests while it makes 230 of them elsewhere.
  constexpr double fewest_steps = 1000;
  const double n_steps = course.moved.sum / course.smallest_change * inside / outside;
  if (!(n_steps > fewest_steps)) return false;
  // Motion below a step makes none however long it goes on, so that what is quieter than elsewhere
  // has to be expected at every sample.
  const auto n_inside = static_cast<double>(course.rest.n);
  const double n_outside = static_cast<double>(course.n) - n_inside;
  return n_steps > n_inside || inside / n_inside > 0.5 * outside / n_outside;
}

CourseRecorder::CourseRecorder(std::vector<Beside> beside)
    : beside_(std::move(beside)),
      courses_(beside_.size()),
      moved_(beside_.size()),
      now_(beside_.size()) {}

void CourseRecorder::close(std::size_t i, ChannelCourse& course) const {
  const Now& now = now_[i];
  if (now.n < Rest::fewest) return;
  Rest rest{now.first_seq, now.last_seq, now.n, now.value, moved_};
  double done = 0, most = 0;
  for (std::size_t j = 0; j < moved_.size(); ++j) {
    rest.during[j].sum -= now.before[j].sum;
    rest.during[j].n -= now.before[j].n;
    if (j < beside_[i].first || j >= beside_[i].end) continue;
    done += rest.during[j].sum;
    if (course.rest.n > 0) most += course.rest.during[j].sum;
  }
  if (done > most || (done == most && rest.n > course.rest.n)) course.rest = std::move(rest);
}

void CourseRecorder::take(std::int64_t seq, const double* values, std::size_t first,
                          std::size_t n) {
  // What moved until the sample before is all that a rest that ends here has been part of.
  for (std::size_t i = first; i < first + n; ++i) {
    Now& now = now_[i];
    if (beside_[i].first == beside_[i].end) continue;
    if (values[i - first] != now.value || courses_[i].n == 0) {
      close(i, courses_[i]);
      now.n = 0;
      now.first_seq = seq;
    }
    now.last_seq = seq;
    if (++now.n == Rest::settled) now.before = moved_;
  }
  for (std::size_t i = first; i < first + n; ++i) {
    ChannelCourse& course = courses_[i];
    const double value = values[i - first];
    if (course.n++ == 0) course.first = course.lowest = course.highest = now_[i].value = value;
    course.lowest = std::min(course.lowest, value);
    course.highest = std::max(course.highest, value);
    // A value that is no number is another one than any.
    if (value != course.first) ++course.n_other;
    if (course.n_other > 0) ++course.n_since;
    const double change = std::abs(value - now_[i].value);
    if (change > 0 && std::isfinite(change)) {
      course.smallest_change = std::min(course.smallest_change, change);
      moved_[i].sum += change;
      ++moved_[i].n;
    }
    now_[i].value = value;
  }
}

std::vector<ChannelCourse> CourseRecorder::courses() const {
  std::vector<ChannelCourse> result = courses_;
  for (std::size_t i = 0; i < result.size(); ++i) {
    close(i, result[i]);
    result[i].moved = moved_[i];
  }
  return result;
}

}  // namespace stillframe::report
