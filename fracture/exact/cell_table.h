// A parallel counting sort by cell. The table has one row of counters for each chunk of each kind of item.
//
//     table.reset(rows, cells);
//     ... each chunk counts its items: ++table.row(r)[cell] ...
//     table.scan(threads);   // turns a counter into the rank of the row's first item within the cell
//     ... each chunk places its items: rank = table.row(r)[cell]++ ...
//
// Ranks follow the order of rows, and of items within a row, so they do not depend on the division into chunks.
#pragma once

#include <cstdint>
#include <vector>

#include "fracture/base/threads.h"

namespace brittle::fracture::exact {

class CellTable {
  public:
    void reset(uint32_t rows, uint32_t cells) {
        rows_ = rows;
        cells_ = cells;
        counts_.assign(size_t{rows} * cells, 0);
    }
    [[nodiscard]] uint32_t* row(uint32_t r) { return counts_.data() + size_t{r} * cells_; }

    // Fills `total` with the number of items in each cell.
    void scan(Threads& threads, std::vector<uint32_t>& total) {
        total.assign(cells_, 0);
        constexpr uint32_t min_cells_per_chunk = 4096;
        threads.for_chunks(cells_, min_cells_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
            for (uint32_t r = 0; r < rows_; ++r) {
                uint32_t* const counts = row(r);
                for (uint32_t c = begin; c < end; ++c) {
                    const uint32_t n = counts[c];
                    counts[c] = total[c];
                    total[c] += n;
                }
            }
        });
    }

  private:
    uint32_t rows_ = 0;
    uint32_t cells_ = 0;
    std::vector<uint32_t> counts_;
};

} // namespace brittle::fracture::exact
