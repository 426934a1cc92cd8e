#include "services/python/arguments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "common/math/nearest_name.hpp"
#include "common/parameters.hpp"
#include "common/set_parameter.hpp"

namespace crsm_python {
namespace {

std::string TypeOf(const py::handle& value) { return Py_TYPE(value.ptr())->tp_name; }

[[noreturn]] void RefuseType(const std::string& name, const py::handle& value, const std::string& expected) {
  throw py::type_error(name + ": is of type " + TypeOf(value) + ", must be " + expected);
}

/// An error of the value's own code goes on as it is.
void ClearTypeError() {
  if (!PyErr_ExceptionMatches(PyExc_TypeError)) throw py::error_already_set();
  PyErr_Clear();
}

std::string ShapeOf(const py::array& array) { return py::str(array.attr("shape")); }

/// The numbers in it, as they are.
py::array ToArray(const py::handle& value, const std::string& name, const std::string& expected) {
  py::object plain = py::reinterpret_borrow<py::object>(value);
  const bool is_plain = TypeOf(value) == "numpy.ndarray";
  const bool is_masked = !is_plain && py::hasattr(value, "filled") && py::hasattr(value, "mask");
  if (is_masked) plain = value.attr("astype")("float32").attr("filled")(std::numeric_limits<float>::quiet_NaN());
  const auto array = py::array::ensure(plain);
  if (!array) RefuseType(name, value, expected);
  if (std::string("fiu").find(array.dtype().kind()) != std::string::npos) return array;
  const std::string dtype = py::str(array.dtype());
  if (py::isinstance<py::array>(value)) throw py::type_error(name + ": has dtype " + dtype + ", must be " + expected);
  RefuseType(name, value, expected);
}

std::vector<float> ToFloats(const py::array& array, const std::string& name, const std::string& hint) {
  if (array.ndim() != 1) {
    throw py::value_error(name + ": must have one dimension, has shape " + ShapeOf(array) + hint);
  }
  const py::array_t<float, py::array::c_style | py::array::forcecast> floats(array);
  return {floats.data(), floats.data() + floats.size()};
}

/// Of a map, with "preset" and "profile".
std::vector<std::string> ListKeys() {
  std::vector<std::string> keys{"preset", "profile"};
  for (const auto& [key, value] : crsm::ListParameters({})) keys.push_back(key);
  return keys;
}

}  // namespace

std::string ToUtf8(const py::handle& text) {
  Py_ssize_t size = 0;
  const char* bytes = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
  if (!bytes) throw py::error_already_set();
  return {bytes, static_cast<std::size_t>(size)};
}

Arguments::Arguments(const char* call, const py::args& words, const py::kwargs& keywords,
                     const std::vector<std::string>& names, std::size_t num_required)
    : call_(call), names_(names) {
  if (words.size() > 1) {
    const std::vector<std::string> others(names_.begin() + 1, names_.end());
    Refuse("takes one argument without a name; name the others: " + crsm::JoinNames(others));
  }
  if (words.size() == 1) Add(names_.front(), words[0]);
  for (const auto& [key, value] : keywords) Add(ToUtf8(key), value);
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < num_required; ++i) {
    if (!values_.contains(names_[i])) missing.push_back(names_[i]);
  }
  if (!missing.empty()) Refuse("needs " + crsm::JoinNames(missing));
}

void Arguments::Add(const std::string& name, const py::handle& value) {
  if (std::ranges::find(names_, name) == names_.end()) {
    Refuse("has no argument " + name + "; it takes " + crsm::JoinNames(names_) + crsm::SuggestName(name, names_));
  }
  if (values_.contains(name)) Refuse("got " + name + " twice");
  values_[name.c_str()] = value;
}

void Arguments::Refuse(const std::string& what) const { throw py::type_error(std::string(call_) + "() " + what); }

py::object Arguments::operator[](const char* name) const {
  return values_.contains(name) ? py::object(values_[name]) : py::none();
}

float ToAngle(const py::handle& value, const char* name) {
  const double angle_rad = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred()) {
    ClearTypeError();
    RefuseType(name, value, "a number of radians");
  }
  return static_cast<float>(angle_rad);
}

std::int64_t ToUtime(const py::handle& value) {
  constexpr std::int64_t kLatest_us = 100'000'000'000'000'000;  // in the year 5138: who is later counts nanoseconds
  if (!PyIndex_Check(value.ptr())) {
    RefuseType("utime", value, "a whole number of microseconds: of seconds, int(1e6 * seconds)");
  }
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!index) throw py::error_already_set();
  int overflow = 0;
  const std::int64_t utime = PyLong_AsLongLongAndOverflow(index.ptr(), &overflow);
  if (overflow > 0 || utime > kLatest_us) {
    throw py::value_error("utime: " + std::string(py::str(value)) +
                          " is too late, must be in microseconds: of nanoseconds, nanoseconds // 1000");
  }
  if (overflow < 0 || utime < 0) throw py::value_error("utime: " + std::string(py::str(value)) + " is negative");
  return utime;
}

std::vector<float> ToFloats(const py::handle& value, const char* name) {
  return ToFloats(ToArray(value, name, "an array of numbers"), name, "");
}

std::vector<float> ToRanges(const py::handle& value) {
  const py::array array = ToArray(value, "ranges_m", "an array of numbers: the range of each beam, NaN for no return");
  std::vector<float> ranges_m = ToFloats(array, "ranges_m", ": it takes the range of each beam, not points");
  if (array.dtype().kind() == 'f') return ranges_m;
  const auto longest = std::ranges::max_element(ranges_m);
  if (longest != ranges_m.end() && *longest > crsm::kLongestRange_m) {
    throw py::value_error("ranges_m: has whole numbers up to " + std::to_string(std::llround(*longest)) +
                          ", must be metres: of millimetres, ranges / 1000");
  }
  return ranges_m;
}

std::optional<crsm_slam::Pose> ToPose(const py::handle& value, const char* name) {
  constexpr double kFurthest = 1e6;
  const std::string expected = "x [m], y [m], yaw [rad]";
  if (value.is_none()) return std::nullopt;
  const py::array array = ToArray(value, name, expected);
  if (array.size() != 3) {
    const bool is_matrix = array.ndim() == 2 && array.size() > 3;
    throw py::value_error(
        std::string(name) + ": must be " + expected + ", has shape " + ShapeOf(array) +
        (is_matrix ? "; of a matrix T these are T[0, -1], T[1, -1], numpy.arctan2(T[1, 0], T[0, 0])" : ""));
  }
  const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(array);
  const crsm_slam::Pose pose{numbers.data()[0], numbers.data()[1], numbers.data()[2]};
  for (const double number : {pose.x_m, pose.y_m, pose.yaw_rad}) {
    if (!(std::abs(number) <= kFurthest)) {
      throw py::value_error(std::string(name) + ": " + std::string(py::str(array.attr("tolist")())) +
                            " must be finite and within 1e6");
    }
  }
  return pose;
}

std::string ToPath(const py::handle& value, const char* name) {
  const auto path = py::reinterpret_steal<py::object>(PyOS_FSPath(value.ptr()));
  if (!path) {
    ClearTypeError();
    RefuseType(name, value, "text or a pathlib.Path");
  }
  PyObject* encoded = nullptr;  // as the file system has it, which need not be UTF-8
  if (PyUnicode_FSConverter(path.ptr(), &encoded) == 0) throw py::error_already_set();
  std::string text = py::reinterpret_steal<py::bytes>(encoded);
  if (text.empty()) throw py::value_error(std::string(name) + ": is empty");
  return text;
}

std::optional<bool> ToBool(const py::handle& value) {
  const bool is_numpy = TypeOf(value) == "numpy.bool" || TypeOf(value) == "numpy.bool_";
  if (!is_numpy && !py::isinstance<py::bool_>(value)) return std::nullopt;
  return PyObject_IsTrue(value.ptr()) == 1;
}

std::string ToText(const py::handle& value) {
  if (const auto flag = ToBool(value)) return *flag ? "true" : "false";
  return py::str(value);
}

crsm_slam::Settings ToSettings(const char* call, const py::args& words, const py::dict& keywords,
                               const std::vector<std::string>& also) {
  if (!words.empty()) {
    throw py::type_error(std::string(call) + "(): settings have names: " + call + "(preset='sick', cell_size_m=0.1)");
  }
  std::vector<std::string> keys = ListKeys();
  keys.insert(keys.end(), also.begin(), also.end());
  crsm_slam::Settings settings;
  for (const auto& [key, value] : keywords) {
    const std::string name = ToUtf8(key);
    if (std::ranges::find(keys, name) == keys.end()) {
      throw py::value_error(name + ": no such key; there are " + crsm::JoinNames(keys) + crsm::SuggestName(name, keys));
    }
    if (value.is_none() || std::ranges::find(also, name) != also.end()) continue;
    if (name == "preset") {
      settings.preset = py::str(value);
    } else if (name == "profile") {
      settings.profile = py::str(value);
    } else {
      settings.values[name] = ToText(value);
    }
  }
  return settings;
}

std::string DescribeSettings() {
  std::string text =
      "  preset: of the laser, one of presets()\n"
      "  profile: 'default', or 'paper', which follows the text of the paper exactly\n";
  const crsm::NamedValues defaults = crsm::ListParameters({});
  auto value = defaults.begin();
  crsm::Parameters parameters;
  crsm::VisitParameters(parameters, [&](const crsm::ParameterInfo& info, auto&, const auto&...) {
    constexpr std::size_t kColumns = 100;
    std::string line = std::string("  ") + info.key + " = " + crsm::FormatValue(value->second) + ":";
    std::istringstream words(info.help);
    for (std::string word; words >> word;) {
      if (line.size() + 1 + word.size() > kColumns) {
        text += line + '\n';
        line = "     ";
      }
      line += ' ' + word;
    }
    text += line + '\n';
    ++value;
  });
  return text;
}

}  // namespace crsm_python
