#pragma once

#include <map>
#include <string>
#include <vector>

namespace crsm {

// What the paper prints. -1: it prints nothing.

struct PaperRow {
  double mfv = -1.0;
  double omse_px2 = -1.0;
  double cmse_px2 = -1.0;
};

/// Tables 1 to 3, by environment and N_HC.
inline const std::map<std::string, std::map<int, PaperRow>> kPaperByEvaluations = {{"env1",
                                                                                    {{100, {0.3668, 410.22, 12032.44}},
                                                                                     {500, {0.576, 15.68, 1562.26}},
                                                                                     {1000, {0.6544, 5.53, 8.04}},
                                                                                     {5000, {0.7079, 6.42, 10.14}},
                                                                                     {10000, {0.7223, 5.40, 4.48}},
                                                                                     {20000, {0.7304, 3.87, 3.03}},
                                                                                     {30000, {0.7374, 3.93, 4.17}}}},
                                                                                   {"env2",
                                                                                    {{100, {0.4400, 216.67, 13012.42}},
                                                                                     {500, {0.5713, 39.78, 4641.84}},
                                                                                     {1000, {0.6075, 32.67, 807.14}},
                                                                                     {5000, {0.6541, 28.45, 1227.52}},
                                                                                     {10000, {0.6730, 24.23, 14.16}},
                                                                                     {20000, {0.6770, 18.24, 11.36}},
                                                                                     {30000, {0.6817, 16.34, 8.08}}}},
                                                                                   {"env3",
                                                                                    {{100, {0.4312, 21.27, 12639.03}},
                                                                                     {500, {0.5398, 21.35, 6195.25}},
                                                                                     {1000, {0.6204, 2.22, 21.00}},
                                                                                     {5000, {0.6788, 0.71, 6.17}},
                                                                                     {10000, {0.6916, 0.76, 4.82}},
                                                                                     {20000, {0.6939, 0.70, 5.15}},
                                                                                     {30000, {0.6949, 0.62, 5.92}}}}};

/// Tables 4 and 5, by environment and selection method.
inline const std::map<std::string, std::map<std::string, PaperRow>> kPaperByMethod = {
    {"env1",
     {{"all", {-1, 4.94, 5.35}},
      {"uniform", {-1, 4.48, 4.78}},
      {"density", {-1, 7.26, 6.14}},
      {"segments", {-1, 5.04, 4.57}}}},
    {"env2",
     {{"all", {-1, 54.41, 3994.91}},
      {"uniform", {-1, 50.29, 4459.27}},
      {"density", {-1, 25.74, 10425.36}},
      {"segments", {-1, 17.56, 10.45}}}},
    {"env3",
     {{"all", {-1, 0.89, 4.50}},
      {"uniform", {-1, 0.89, 3.37}},
      {"density", {-1, 3.76, 5832.5}},
      {"segments", {-1, 0.76, 3.75}}}}};

struct PaperTime {
  double ms = -1.0;
  double rays = -1.0;
};

/// Table 6, by environment and selection method; a Core i7 of 2.8 GHz.
inline const std::map<std::string, std::map<std::string, PaperTime>> kPaperTimes = {
    {"env1",
     {{"all", {241.7, 247.24}}, {"uniform", {62.14, 49.43}}, {"density", {44.67, 30.85}}, {"segments", {66.8, 49.33}}}},
    {"env2",
     {{"all", {248.54, 266.26}}, {"uniform", {61.74, 53.26}}, {"density", {44.27, 32.6}}, {"segments", {54.2, 45.78}}}},
    {"env3",
     {{"all", {253.23, 268.4}},
      {"uniform", {63.86, 53.66}},
      {"density", {46.53, 34.27}},
      {"segments", {55.53, 42.57}}}},
    {"env4",
     {{"all", {658.96, 555.54}},
      {"uniform", {57.65, 38.02}},
      {"density", {55.16, 33.82}},
      {"segments", {86.78, 54.04}}}}};

}  // namespace crsm
