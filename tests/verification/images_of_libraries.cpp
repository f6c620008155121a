// Images that the libraries of users' programs write - ITK, GDCM, libtiff, VTK - give the same voxels and axes.
#include <fmt/format.h>
#include <itkGDCMImageIO.h>
#include <itkImage.h>
#include <itkImageFileWriter.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>
#include <vtkCellData.h>
#include <vtkImageData.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnsignedShortArray.h>
#include <vtkXMLImageDataWriter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "io/image.hpp"
#include "support/helpers.hpp"
#include "support/image_files.hpp"

namespace porepack {
namespace {

using namespace imaging;
using namespace test::image_files;
using core::UserError;

using ItkImage = itk::Image<std::uint16_t, 3>;
ItkImage::Pointer itk_image(const std::array<int, 3>& order = {0, 1, 2}) {
    const auto image = ItkImage::New();
    ItkImage::SizeType size;
    ItkImage::SpacingType spacing;
    for (unsigned i = 0; i < 3; ++i) {
        size[i] = static_cast<itk::SizeValueType>(n[static_cast<std::size_t>(order[i])]);
        spacing[i] = 1e3 * h;  // millimetres
    }
    image->SetRegions(size);
    image->SetSpacing(spacing);
    image->Allocate();
    const auto values = values_of<std::uint16_t>(order);
    std::copy(values.begin(), values.end(), image->GetBufferPointer());
    return image;
}
void itk_write(const ItkImage::Pointer& image, itk::ImageIOBase* io, const Path& path, bool compressed) {
    const auto writer = itk::ImageFileWriter<ItkImage>::New();
    writer->SetImageIO(io);
    writer->SetInput(image);
    writer->SetFileName(path.string());
    writer->SetUseCompression(compressed);
    writer->Update();
}

TEST(Images, MetaImageAndNrrdOfItk) {
    const test::Folder folder;
    const ImageConfig mm = {.unit_m = 1e-3};
    for (const bool compressed : {false, true}) {
        for (const char* name : {"l.mha", "l.mhd"}) {
            itk_write(itk_image(), itk::MetaImageIO::New(), folder.path() / name, compressed);
            expect_body(folder.path() / name, mm, "MetaImage, uint16");
        }
        for (const char* name : {"l.nrrd", "l.nhdr"}) {
            itk_write(itk_image(), itk::NrrdImageIO::New(), folder.path() / name, compressed);
            expect_body(folder.path() / name, mm, "NRRD, uint16");
        }
    }
    // Permuted and mirrored axes come from the direction matrix: file axis 0 is z, axis 1 is -x, axis 2 is y.
    const ItkImage::Pointer turned = itk_image({2, 0, 1});
    ItkImage::DirectionType direction;
    direction.Fill(0.0);
    direction[2][0] = 1.0;
    direction[0][1] = 1.0;
    direction[1][2] = 1.0;
    turned->SetDirection(direction);
    itk_write(turned, itk::NrrdImageIO::New(), folder.path() / "t.nrrd", true);
    expect_body(folder.path() / "t.nrrd", mm, "NRRD");
    EXPECT_TRUE(test::has(open_volume(folder.path() / "t.nrrd", mm).header.orientation, "z, x, y (direction in the file)"));
    const ItkImage::Pointer mirrored = itk_image();
    auto* begin = mirrored->GetBufferPointer();
    std::reverse(begin, begin + n[0] * n[1] * n[2]);
    direction.Fill(0.0);
    for (unsigned i = 0; i < 3; ++i) direction[i][i] = -1.0;
    mirrored->SetDirection(direction);
    itk_write(mirrored, itk::MetaImageIO::New(), folder.path() / "m.mha", false);
    expect_body(folder.path() / "m.mha", mm, "MetaImage");
    // Oblique axes.
    direction.SetIdentity();
    direction[0][0] = direction[1][1] = std::cos(0.1);
    direction[0][1] = -std::sin(0.1);
    direction[1][0] = std::sin(0.1);
    mirrored->SetDirection(direction);
    itk_write(mirrored, itk::NrrdImageIO::New(), folder.path() / "o.nrrd", false);
    EXPECT_TRUE(test::has(test::message_of<UserError>([&] { (void)open_volume(folder.path() / "o.nrrd", mm); }), "it is oblique"));
}

TEST(Images, DicomSeries) {
    const test::Folder folder;
    // One file per layer, numbered against their positions: the positions count.
    for (int z = 0; z < n[2]; ++z) {
        const auto layer = ItkImage::New();
        ItkImage::SizeType size = {{6, 5, 1}};
        layer->SetRegions(size);
        ItkImage::SpacingType spacing;
        spacing.Fill(1e3 * h);
        layer->SetSpacing(spacing);
        ItkImage::PointType origin;
        origin.Fill(0.0);
        origin[2] = 1e3 * h * z;
        layer->SetOrigin(origin);
        layer->Allocate();
        const auto values = values_of<std::uint16_t>();
        std::copy_n(values.begin() + z * n[0] * n[1], n[0] * n[1], layer->GetBufferPointer());
        const auto io = itk::GDCMImageIO::New();
        auto& header = layer->GetMetaDataDictionary();
        const std::string position = fmt::format("0\\0\\{:.6f}", 1e3 * h * z);
        itk::EncapsulateMetaData<std::string>(header, "0020|000e", "1.2.826.0.1.3680043.2.1125.1");
        itk::EncapsulateMetaData<std::string>(header, "0020|0032", position);
        itk::EncapsulateMetaData<std::string>(header, "0008|0060", "CT");
        io->KeepOriginalUIDOn();
        itk_write(layer, io, folder.path() / fmt::format("slice_{}.dcm", n[2] - z), false);
    }
    expect_body(folder.path(), {}, "DICOM, uint16, 4 files");
    // A byte is missing: GDCM would read a zero.
    const std::string whole = read_text(folder.path() / "slice_3.dcm");
    write_text(folder.path() / "slice_3.dcm", whole.substr(0, whole.size() - 1));
    EXPECT_TRUE(test::has(test::message_of<UserError>([&] {
                              const VolumeSource source = open_volume(folder.path());
                              std::vector<float> all(static_cast<std::size_t>(source.header.count()));
                              source.read(0, all);
                          }),
                          "not all there"));
    write_text(folder.path() / "slice_3.dcm", whole);
    std::filesystem::remove(folder.path() / "slice_2.dcm");
    EXPECT_TRUE(test::has(test::message_of<UserError>([&] {
                              const VolumeSource source = open_volume(folder.path());
                              std::vector<float> all(static_cast<std::size_t>(source.header.count()));
                              source.read(0, all);
                          }),
                          "not equally distant"));
}

TEST(Images, TiffPagesAndStacks) {
    const test::Folder folder;
    const auto values = values_of<std::uint16_t>();
    const std::size_t layer = static_cast<std::size_t>(n[0] * n[1]);
    for (const char* mode : {"w", "w8"}) {  // and BigTIFF
        TIFF* file = TIFFOpen((folder.path() / "l.tif").c_str(), mode);
        for (std::size_t z = 0; z < 4; ++z)
            tiff_page(file, values.data() + z * layer, z == 0 ? "ImageJ=1.53\nimages=4\nslices=4\nunit=mm\nspacing=0.02\n" : nullptr);
        TIFFClose(file);
        expect_body(folder.path() / "l.tif", {}, "TIFF, uint16, 4 pages");
    }
    // Numbers without leading zeros: slice_10 comes after slice_9.
    std::filesystem::create_directories(folder.path() / "stack");
    for (std::size_t z = 0; z < 4; ++z) {
        TIFF* file = TIFFOpen((folder.path() / "stack" / fmt::format("slice_{}.tif", z + 8)).c_str(), "w");
        tiff_page(file, values.data() + z * layer, nullptr);
        TIFFClose(file);
    }
    expect_body(folder.path() / "stack", sized, "TIFF, uint16, 4 files, slice_8.tif to slice_11.tif");
}

TEST(Images, PngStack) {
    const test::Folder folder;
    const auto values = values_of<std::uint8_t>();
    for (int z = 0; z < n[2]; ++z) {
        std::vector<std::uint8_t> rows;  // the writer begins at the bottom, the file at the top
        for (int y = n[1] - 1; y >= 0; --y)
            rows.insert(rows.end(), values.begin() + (z * n[1] + y) * n[0], values.begin() + (z * n[1] + y + 1) * n[0]);
        io::write_gray_png(folder.path() / fmt::format("z{:03}.png", z), n[0], n[1], rows);
    }
    expect_body(folder.path(), sized, "PNG, uint8, 4 files");
}

TEST(Images, VtkImagesOfEveryKind) {
    const test::Folder folder;
    const Path file = folder.path() / "l.vti";
    const auto values = values_of<std::uint16_t>();
    for (const bool at_points : {false, true})
        for (const int mode : {0, 1, 2})
            for (const int compressor : {0, 1, 2}) {
                vtkNew<vtkImageData> image;
                const int more = at_points ? -1 : 0;
                image->SetExtent(3, 3 + n[0] + more, -2, -2 + n[1] + more, 7, 7 + n[2] + more);  // extents need not begin at 0
                image->SetSpacing(h, h, h);
                vtkNew<vtkUnsignedShortArray> array;
                array->SetName("gray");
                for (const std::uint16_t value : values) array->InsertNextValue(value);
                if (at_points)
                    image->GetPointData()->AddArray(array);
                else
                    image->GetCellData()->AddArray(array);
                vtkNew<vtkXMLImageDataWriter> writer;
                writer->SetFileName(file.c_str());
                writer->SetInputData(image);
                writer->SetDataMode(mode);
                if (compressor == 0) writer->SetCompressorTypeToNone();
                if (compressor == 2) writer->SetCompressor(vtkNew<vtkLZ4DataCompressor>());
                ASSERT_EQ(writer->Write(), 1);
                expect_body(file, {.unit_m = 1.0, .field = "gray"}, at_points ? "`gray` at points" : "`gray` at cells");
                const auto origin = open_volume(file, {.unit_m = 1.0}).header.origin_m;
                EXPECT_NEAR(origin[0], h * (3.0 - (at_points ? 0.5 : 0.0)), 1e-12);
                EXPECT_NEAR(origin[1], h * (-2.0 - (at_points ? 0.5 : 0.0)), 1e-12);
            }
}

// Two pieces along y, as parallel writers make them; and files whose pieces or arrays are not those of the image.
TEST(Images, VtkPieces) {
    const test::Folder folder;
    const Path file = folder.path() / "l.vti";
    const auto piece = [&](int y0, int y1, int left_out) {
        std::string text =
            fmt::format("<Piece Extent=\"0 6 {} {} 0 4\"><CellData><DataArray type=\"UInt8\" Name=\"a\" format=\"ascii\">", y0, y1);
        int count = 0;
        for (int z = 0; z < n[2]; ++z)
            for (int y = y0; y < y1; ++y)
                for (int x = 0; x < n[0]; ++x)
                    if (count++ >= left_out) text += fmt::format("{} ", value_at(x, y, z));
        for (; left_out < 0; ++left_out) text += "1 ";
        return text + "</DataArray></CellData></Piece>";
    };
    const auto write = [&](const std::string& pieces) {
        core::write_text(file,
                         "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"0 6 0 5 0 4\" "
                         "Origin=\"0 0 0\" Spacing=\"2e-5 2e-5 2e-5\">" +
                             pieces + "</ImageData></VTKFile>");
    };
    const ImageConfig metres = {.unit_m = 1.0};
    write(piece(0, 2, 0) + piece(2, 5, 0));
    expect_body(file, metres, "VTK image");
    const auto fault = [&](const std::string& pieces, const char* message) {
        write(pieces);
        EXPECT_TRUE(test::has(test::message_of<UserError>([&] { (void)open_volume(file, metres); }), message)) << message;
    };
    fault(piece(0, 2, 0), "its pieces do not fill WholeExtent");
    fault(piece(0, 3, 0) + piece(2, 5, 0), "pieces 1 and 2 overlap");
    fault(piece(0, 2, 0) + piece(2, 6, 0), "piece 2 reaches beyond WholeExtent");
    fault(piece(0, 5, 1), "has fewer values than the image");
    fault(piece(0, 5, -1), "has more values than the image");
    fault("", "it has no pieces");
}

}  // namespace
}  // namespace porepack
