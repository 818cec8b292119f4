// A driver over the binary form: follows the route, keeps a time gap of 2 s to the actor in its way, stops at red lights.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

static std::string hello;
static int setting(const std::string& key) { return std::atoi(&hello[hello.find("\"" + key + "\":") + key.size() + 3]); }

int main() {
  for (int c; (c = std::getchar()) != '\n' && c != EOF;) hello += char(c);
  std::puts("{\"protocol\":\"falsify-av/1\",\"encoding\":\"binary\",\"control\":\"acceleration\"}");
  std::fflush(stdout);
  const size_t actors = setting("actors"), points = setting("route_points"), size = 14 + 8 * actors + 3 * points;
  std::vector<double> in, out;
  for (uint32_t bytes; std::fread(&bytes, 4, 1, stdin) == 1; out.clear()) {
    in.resize(bytes / 8);
    if (std::fread(in.data(), 8, in.size(), stdin) != in.size()) return 1;
    for (const double* w = in.data(); w != in.data() + in.size(); w += size) {
      const double x = w[3], y = w[4], c = std::cos(w[5]), s = std::sin(w[5]), speed = w[6], limit = w[7];
      double wanted = 0.9 * limit, steer = 0;
      auto give_way = [&](double gap) { wanted = std::min(wanted, std::max(0.0, gap - 2) / 2); };
      if (w[8] == 3) give_way(w[9]);  // red
      for (const double* a = w + 14; a != w + 14 + 8 * int(w[12]); a += 8) {
        const double ahead = c * (a[1] - x) + s * (a[2] - y), left = c * (a[2] - y) - s * (a[1] - x);
        if (ahead > 0 && std::abs(left) < 2) give_way(ahead - 2.5);
      }
      const double* route = w + 14 + 8 * actors;
      for (const double* p = route; p != route + 3 * int(w[13]); p += 3) {
        const double ahead = c * (p[0] - x) + s * (p[1] - y), left = c * (p[1] - y) - s * (p[0] - x);
        if (std::hypot(ahead, left) > 3.5 + 0.6 * speed) { steer = std::clamp(2 * std::atan2(left, ahead), -1.0, 1.0); break; }
      }
      const double change = w[13] ? std::clamp(2 * (wanted - speed), -8.0, 2.0) : -2;  // without a route the road has ended
      out.insert(out.end(), {w[0], change, 0, steer});
    }
    const uint32_t length = 8 * out.size();
    std::fwrite(&length, 4, 1, stdout);
    std::fwrite(out.data(), 8, out.size(), stdout);
    std::fflush(stdout);
  }
}
