#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <crsm_slam/slam.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crsm_python {

namespace py = pybind11;

/// A str as UTF-8. Throws UnicodeEncodeError where it is none, as a file name that is not UTF-8 is in Python.
std::string ToUtf8(const py::handle& text);

// What Python gives as arguments. Each refusal is one line that names the argument and says what would be right:
// TypeError where the type is wrong, ValueError where the value is.

/// The arguments of one call, by their names. The first one may stand without its name.
class Arguments {
 public:
  /// call: "Slam.process". Throws TypeError for arguments that are not among the names, and for missing ones: of
  /// `names`, which must outlive this, the first `num_required` must be there.
  Arguments(const char* call, const py::args& words, const py::kwargs& keywords, const std::vector<std::string>& names,
            std::size_t num_required);

  /// None if it is not there.
  py::object operator[](const char* name) const;

 private:
  void Add(const std::string& name, const py::handle& value);
  [[noreturn]] void Refuse(const std::string& what) const;

  const char* call_;
  const std::vector<std::string>& names_;
  py::dict values_;
};

/// An angle in radians.
float ToAngle(const py::handle& value, const char* name);

/// A time in microseconds.
std::int64_t ToUtime(const py::handle& value);

/// An array with one dimension. Masked elements are NaN.
std::vector<float> ToFloats(const py::handle& value, const char* name);

/// As above: ranges in metres.
std::vector<float> ToRanges(const py::handle& value);

/// Three numbers, or None.
std::optional<crsm_slam::Pose> ToPose(const py::handle& value, const char* name);

/// Text or a pathlib.Path.
std::string ToPath(const py::handle& value, const char* name);

/// How a flag or a file would say it.
std::string ToText(const py::handle& value);

/// True, False, or NumPy's.
std::optional<bool> ToBool(const py::handle& value);

/// Settings of a map by their keys; None counts as not given. also: keys that are none, and are left out. Throws
/// TypeError for settings without a key, and ValueError for an unknown key.
crsm_slam::Settings ToSettings(const char* call, const py::args& words, const py::dict& keywords,
                               const std::vector<std::string>& also = {});

/// A line or more for each setting of a map: its key, its default value and its meaning.
std::string DescribeSettings();

}  // namespace crsm_python
