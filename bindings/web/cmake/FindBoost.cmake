# The headers of Debian's libboost-dev, which are for every platform.
add_library(Boost::headers INTERFACE IMPORTED)
target_include_directories(Boost::headers INTERFACE ${WEB_HEADERS})
set(Boost_FOUND TRUE)
