# Targets: isomend::isomend, the shared library, and isomend::static, the static one.
get_filename_component(isomend_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET isomend::isomend)
    add_library(isomend::isomend SHARED IMPORTED)
    set_target_properties(isomend::isomend PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${isomend_prefix}/include"
        IMPORTED_NO_SONAME TRUE)
    if(WIN32)
        set_target_properties(isomend::isomend PROPERTIES
            IMPORTED_LOCATION "${isomend_prefix}/bin/isomend.dll"
            IMPORTED_IMPLIB "${isomend_prefix}/lib/isomend.dll.lib")
    else()
        set_target_properties(isomend::isomend PROPERTIES
            IMPORTED_LOCATION "${isomend_prefix}/lib/libisomend${CMAKE_SHARED_LIBRARY_SUFFIX}")
    endif()

    add_library(isomend::static STATIC IMPORTED)
    set_target_properties(isomend::static PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${isomend_prefix}/include"
        IMPORTED_LOCATION "${isomend_prefix}/lib/${CMAKE_STATIC_LIBRARY_PREFIX}isomend${CMAKE_STATIC_LIBRARY_SUFFIX}")
    if(WIN32)
        set_property(TARGET isomend::static PROPERTY INTERFACE_LINK_LIBRARIES ws2_32 ntdll userenv bcrypt)
    elseif(APPLE)
        set_property(TARGET isomend::static PROPERTY INTERFACE_LINK_LIBRARIES "-framework CoreFoundation" iconv m)
    else()
        set_property(TARGET isomend::static PROPERTY INTERFACE_LINK_LIBRARIES gcc_s util rt pthread m dl c)
    endif()
endif()
