// Configuration files: taken, or refused in words. No value gets past its range.

#include "input.hpp"
#include "services/settings/command_line.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  const MemoryFile file({data, size});
  const std::string path = file.path();
  const char* arguments[] = {"fuzz", "--config", path.c_str()};
  CommandLine command_line("fuzz", "", {}, {});
  const auto exit_code = command_line.Parse(3, arguments);
  if (exit_code && *exit_code != 2) std::abort();

  Parameters parameters = command_line.parameters();
  const auto Check = [](auto value, auto low, auto high) {
    if (!(value >= low && value <= high)) std::abort();
  };
  VisitParameters(parameters, [&]<class T, class... Rest>(const ParameterInfo&, T& value, const Rest&... rest) {
    if constexpr (sizeof...(Rest) == 2) Check(value, rest...);
  });
  return 0;
}
