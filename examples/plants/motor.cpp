// The paper's DC motor as a plant in C++: it reads u and prints y, and needs no library.
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <string>

int main() {
    const char *told = std::getenv("WEBLOOP_H_S");
    if (!told) {
        std::cerr << "WEBLOOP_H_S is not set; start this by webloop serve plant or webloop conform --plant\n";
        return 2;
    }
    const double h = std::stod(told);
    double x = 0, y = 0;
    std::cout << std::setprecision(17) << y << std::endl;  // the y that it starts with
    for (std::string u; std::getline(std::cin, u);) {
        x = (x + h * 2029.826 * std::stod(u)) / (1 + h * 26.29);  // backward Euler, as in the paper
        y = (y + h * x) / (1 + h * 2.296);
        std::cout << y << std::endl;  // one y for each u, and not in a buffer
    }
}
