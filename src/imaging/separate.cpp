#include "imaging/separate.hpp"

#include <fmt/format.h>
#include <itkBinaryFillholeImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkHMinimaImageFilter.h>
#include <itkImage.h>
#include <itkImportImageFilter.h>
#include <itkMaskImageFilter.h>
#include <itkMorphologicalWatershedFromMarkersImageFilter.h>
#include <itkMultiThreaderBase.h>
#include <itkRegionalMinimaImageFilter.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/machine.hpp"

namespace porepack::imaging {
namespace {

using Mask = itk::Image<std::uint8_t, 3>;
using Field = itk::Image<float, 3>;
using Labels = itk::Image<std::uint32_t, 3>;

// Refers to the values; nothing is copied.
Mask::Pointer mask_of(const Grid& grid, const std::vector<std::uint8_t>& solid) {
    auto import = itk::ImportImageFilter<std::uint8_t, 3>::New();
    Mask::SizeType size;
    Mask::IndexType start;
    start.Fill(0);
    for (unsigned a = 0; a < 3; ++a) size[a] = static_cast<Mask::SizeValueType>(grid.cells[a]);
    import->SetRegion({start, size});
    import->SetSpacing(grid.spacing_m.data());
    import->SetImportPointer(const_cast<std::uint8_t*>(solid.data()), solid.size(), false);
    import->Update();
    return import->GetOutput();
}

void use_threads() {
    itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(static_cast<itk::ThreadIdType>(thread_count()));
}

}  // namespace

std::int64_t fill_cavities(const Grid& grid, std::vector<std::uint8_t>& solid) {
    use_threads();
    auto fill = itk::BinaryFillholeImageFilter<Mask>::New();
    fill->SetInput(mask_of(grid, solid));
    fill->SetForegroundValue(1);
    fill->SetFullyConnected(false);
    fill->Update();
    const std::uint8_t* filled = fill->GetOutput()->GetBufferPointer();
    std::int64_t count = 0;
    for (std::size_t cell = 0; cell < solid.size(); ++cell)
        if (filled[cell] != 0 && solid[cell] == 0) {
            solid[cell] = 1;
            ++count;
        }
    return count;
}

Separated separate_grains(const Grid& grid, const std::vector<std::uint8_t>& solid, double height_m) {
    constexpr double bytes_per_voxel = 33.0;
    require_memory(bytes_per_voxel * static_cast<double>(solid.size()), "the watershed", "crop or bin the image (porepack image crop|bin)");
    use_threads();
    const Mask::Pointer mask = mask_of(grid, solid);
    auto distance = itk::SignedMaurerDistanceMapImageFilter<Mask, Field>::New();
    distance->SetInput(mask);
    distance->SetSquaredDistance(false);
    distance->SetUseImageSpacing(true);
    distance->SetInsideIsPositive(false);
    distance->Update();
    const Field::Pointer depth = distance->GetOutput();  // negative in the grains
    depth->DisconnectPipeline();

    auto flat = itk::HMinimaImageFilter<Field, Field>::New();
    flat->SetInput(depth);
    flat->SetHeight(static_cast<float>(height_m));
    flat->SetFullyConnected(true);
    auto minima = itk::RegionalMinimaImageFilter<Field, Mask>::New();
    minima->SetInput(flat->GetOutput());
    minima->SetFullyConnected(true);
    minima->SetForegroundValue(1);
    minima->SetBackgroundValue(0);
    minima->SetFlatIsMinima(false);
    auto inside = itk::MaskImageFilter<Mask, Mask>::New();
    inside->SetInput(minima->GetOutput());
    inside->SetMaskImage(mask);
    auto markers = itk::ConnectedComponentImageFilter<Mask, Labels>::New();
    markers->SetInput(inside->GetOutput());
    markers->SetFullyConnected(true);
    markers->Update();
    const Labels::Pointer seeds = markers->GetOutput();
    seeds->DisconnectPipeline();

    auto watershed = itk::MorphologicalWatershedFromMarkersImageFilter<Field, Labels>::New();
    watershed->SetInput1(depth);
    watershed->SetInput2(seeds);
    watershed->SetMarkWatershedLine(false);
    watershed->SetFullyConnected(true);
    watershed->Update();
    const std::uint32_t* found = watershed->GetOutput()->GetBufferPointer();
    Separated result{.label = std::vector<std::uint32_t>(solid.size(), 0)};
    for (std::size_t cell = 0; cell < solid.size(); ++cell) {
        result.label[cell] = solid[cell] != 0 ? found[cell] : 0;
        result.count = std::max(result.count, result.label[cell]);
    }
    return result;
}

}  // namespace porepack::imaging
