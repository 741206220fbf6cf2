# Everything comes from Debian packages (scripts/packages.txt) and, for the code generators, from .venv.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(SUNDIALS REQUIRED COMPONENTS cvode arkode nvecserial sunmatrixdense sunlinsoldense sunnonlinsolfixedpoint)
find_package(HDF5 1.10 REQUIRED COMPONENTS C)
find_package(fmt 9 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(tomlplusplus 3.3 REQUIRED)
