// The paper's PI controller for the motor, in C++17 on POSIX sockets.
//
//     c++ -O2 -std=c++17 -o pi pi.cpp
//
// On ARM add -ffp-contract=off: it has a fused multiply-add, which rounds once where others round twice.
#include "webloop.hpp"

int main() {
    double integral = 0.0;
    return webloop::control([&](double r, double y, double dt_s) {
        const double e = r - y;
        integral += 0.378 * dt_s * e;
        return 0.1701 * e + integral;
    });
}
