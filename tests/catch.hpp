#pragma once

// Catch2 version 3 (Debian 13, Ubuntu 24.04) and version 2 (Debian 12) differ in where things live.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif
